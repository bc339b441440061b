// SPDX-License-Identifier: GPL-3.0-or-later
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "io/formats.hpp"

namespace surfaced::io {
namespace {

using draco::GeometryAttribute;

/// Least and most effort of Draco; in between it decides by speed which predictions it tries.
constexpr int kSpeed = 3;
/// Bits of a float32. On a finer grid Draco would count how often each step occurs, in a table of all steps: 4 GB for
/// 30 bits.
constexpr int kMostQuantised = std::numeric_limits<float>::digits;
/// Beyond it Draco's differences of floats overflow and end in addresses that are not its own.
constexpr double kLargestQuantised = 1e37;
/// Bytes before the triangles: header and two counts.
constexpr std::size_t kMostHeader = 11 + 5 + 5;

/// Adds an attribute with a value per point, in the points' order.
template <class T, std::size_t N>
void add_attribute(draco::Mesh& mesh, GeometryAttribute::Type type, draco::DataType data_type, bool normalized,
                   const std::vector<std::array<T, N>>& values) {
  GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<std::uint8_t>(N), data_type, normalized, sizeof(values[0]), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  mesh.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(values[0]));
}

void add_scalar(draco::Mesh& mesh, const std::vector<float>& values) {
  GeometryAttribute attribute;
  attribute.Init(GeometryAttribute::GENERIC, nullptr, 1, draco::DT_FLOAT32, false, sizeof(float), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  mesh.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(float));
}

void add_positions(draco::Mesh& target, const TriangleMesh& mesh, bool narrow) {
  if (!narrow) return add_attribute(target, GeometryAttribute::POSITION, draco::DT_FLOAT64, false, mesh.positions);
  std::vector<std::array<float, 3>> positions;
  positions.reserve(mesh.positions.size());
  for (const Point3& p : mesh.positions) {
    positions.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  add_attribute(target, GeometryAttribute::POSITION, draco::DT_FLOAT32, false, positions);
}

/// The bits to which the positions can be quantised; none if they stay as they are.
std::optional<int> bits_for(const std::vector<Point3>& positions, const std::optional<int>& bits) {
  if (!bits || *bits > kMostQuantised) return {};
  const auto fits = [](const Point3& p) {
    return std::ranges::all_of(p, [](double x) { return std::abs(x) < kLargestQuantised; });
  };
  return std::ranges::all_of(positions, fits) ? bits : std::nullopt;
}

/// Sequential, because the other encoding, edgebreaker, reorders vertices and splits those that are not
/// manifold.
draco::Status encode(const draco::Mesh& mesh, const std::optional<int>& bits, draco::EncoderBuffer& buffer) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.options().SetGlobalBool("compress_connectivity", true);
  if (bits) encoder.SetAttributeQuantization(GeometryAttribute::POSITION, *bits);
  return encoder.EncodeMeshToBuffer(mesh, &buffer);
}

}  // namespace

Result<Bytes> write_draco(const TriangleMesh& mesh, const std::optional<int>& bits,
                          const std::vector<VertexScalar>& scalars) {
  if (mesh.triangles.empty())
    return Error{ErrorCode::method_failed, "the mesh has no triangles; Draco cannot hold that"};
  if (mesh.positions.size() > 3 * mesh.triangles.size()) {  // its decoder takes that for a lie
    return Error{ErrorCode::unsupported_feature, std::to_string(mesh.positions.size()) + " vertices in " +
                                                     std::to_string(mesh.triangles.size()) +
                                                     " triangles; a Draco mesh holds at most 3 vertices per triangle"};
  }
  draco::Mesh target;
  target.set_num_points(static_cast<std::uint32_t>(mesh.positions.size()));
  const std::optional<int> used_bits = bits_for(mesh.positions, bits);
  // Draco quantises float32 only; without quantisation doubles are kept as they are.
  const bool more_than_floats_have = bits && *bits > kMostQuantised;
  add_positions(target, mesh, used_bits || more_than_floats_have || fits_float32(mesh.positions));
  if (!mesh.normals.empty()) {
    add_attribute(target, GeometryAttribute::NORMAL, draco::DT_FLOAT32, false, mesh.normals);
  }
  if (!mesh.colors.empty()) add_attribute(target, GeometryAttribute::COLOR, draco::DT_UINT8, true, mesh.colors);
  for (const VertexScalar& scalar : scalars) add_scalar(target, scalar.values);
  target.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    target.SetFace(draco::FaceIndex(f),
                   {draco::PointIndex(t[0].value), draco::PointIndex(t[1].value), draco::PointIndex(t[2].value)});
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = encode(target, used_bits, buffer);
  if (!status.ok()) return Error{ErrorCode::internal_error, "Draco refused the mesh: " + status.error_msg_string()};
  const auto* begin = reinterpret_cast<const std::byte*>(buffer.data());
  Bytes bytes(begin, begin + buffer.size());
  // Draco's decoder takes more triangles than a third of the bytes left for a lie, though its encoder can
  // do better than that. It ignores bytes after the end, so a file too short for it is filled up.
  bytes.resize(std::max(bytes.size(), kMostHeader + 3 * mesh.triangles.size()));
  return bytes;
}

}  // namespace surfaced::io
