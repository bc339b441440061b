// SPDX-License-Identifier: GPL-3.0-or-later
// Draco files of every kind that Draco writes, made by Draco.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <draco/metadata/geometry_metadata.h>
#include <draco/point_cloud/point_cloud.h>

#include <memory>
#include <string>
#include <vector>

#include "support/shapes.hpp"

namespace surfaced::testing {

struct DracoFile {
  std::string name;
  std::vector<std::byte> bytes;
  /// Coordinates are those of draco_points(), bit for bit and in their order.
  bool exact = false;
  bool mesh = false;
};

/// Points of the files: those of a torus, as float32.
inline TriangleMesh draco_shape(std::size_t around = 9, std::size_t along = 7) {
  TriangleMesh mesh = torus_mesh(around, along);
  for (Point3& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  return mesh;
}

namespace draco_detail {

template <class T, std::size_t N>
int add(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, draco::DataType data_type,
        const std::vector<std::array<T, N>>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<std::uint8_t>(N), data_type, data_type == draco::DT_UINT8,
                 sizeof(values[0]), 0);
  const int id = cloud.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  cloud.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(values[0]));
  return id;
}

inline void fill(draco::PointCloud& cloud, const TriangleMesh& shape, bool with_attributes) {
  using draco::GeometryAttribute;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<std::uint8_t, 4>> colors;
  for (std::size_t i = 0; i < shape.positions.size(); ++i) {
    const Point3& p = shape.positions[i];
    positions.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    normals.push_back({0, 0.6F, i % 2 == 0 ? 0.8F : -0.8F});
    colors.push_back({static_cast<std::uint8_t>(i), 50, 200, 255});
  }
  cloud.set_num_points(static_cast<std::uint32_t>(positions.size()));
  add(cloud, GeometryAttribute::POSITION, draco::DT_FLOAT32, positions);
  if (!with_attributes) return;
  add(cloud, GeometryAttribute::NORMAL, draco::DT_FLOAT32, normals);
  add(cloud, GeometryAttribute::COLOR, draco::DT_UINT8, colors);
}

inline std::unique_ptr<draco::Mesh> mesh_of(const TriangleMesh& shape, bool with_attributes) {
  auto mesh = std::make_unique<draco::Mesh>();
  fill(*mesh, shape, with_attributes);
  mesh->SetNumFaces(shape.triangles.size());
  for (std::uint32_t f = 0; f < shape.triangles.size(); ++f) {
    const Triangle& t = shape.triangles[f];
    mesh->SetFace(draco::FaceIndex(f),
                  {draco::PointIndex(t[0].value), draco::PointIndex(t[1].value), draco::PointIndex(t[2].value)});
  }
  return mesh;
}

inline void add_metadata(draco::PointCloud& cloud) {
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  metadata->AddEntryString("made_by", "a test");
  auto nested = std::make_unique<draco::Metadata>();
  nested->AddEntryInt("answer", 42);
  metadata->AddSubMetadata("nested", std::move(nested));
  auto attribute = std::make_unique<draco::AttributeMetadata>();
  attribute->AddEntryString("name", "position");
  attribute->set_att_unique_id(0);
  metadata->AddAttributeMetadata(std::move(attribute));
  cloud.AddMetadata(std::move(metadata));
}

inline std::vector<std::byte> bytes_of(const draco::EncoderBuffer& buffer) {
  const auto* begin = reinterpret_cast<const std::byte*>(buffer.data());
  return {begin, begin + buffer.size()};
}

}  // namespace draco_detail

/// How a file is encoded; method 1 is the kd-tree for clouds, the edgebreaker for meshes.
struct DracoChoice {
  bool mesh = false;
  int method = 0;
  int bits = 0;
  int speed = 5;
  bool attributes = false;

  std::string name() const {
    const std::string kind = method == 0 ? "sequential" : mesh ? "edgebreaker" : "kd";
    return std::string(mesh ? "mesh_" : "cloud_") + kind + "_bits" + std::to_string(bits) + "_speed" +
           std::to_string(speed) + (attributes ? "_all" : "");
  }
};

/// @return  no bytes if Draco does not write such a file.
inline DracoFile draco_file(const TriangleMesh& shape, const DracoChoice& choice) {
  using namespace draco_detail;
  std::unique_ptr<draco::PointCloud> cloud;
  if (choice.mesh) {
    cloud = mesh_of(shape, choice.attributes);
  } else {
    cloud = std::make_unique<draco::PointCloud>();
    fill(*cloud, shape, choice.attributes);
  }
  if (choice.speed == 0) add_metadata(*cloud);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(choice.method);
  encoder.SetSpeedOptions(choice.speed, choice.speed);
  if (choice.bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, choice.bits);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 8);
  }
  draco::EncoderBuffer buffer;
  const draco::Status status = choice.mesh
                                   ? encoder.EncodeMeshToBuffer(static_cast<const draco::Mesh&>(*cloud), &buffer)
                                   : encoder.EncodePointCloudToBuffer(*cloud, &buffer);
  if (!status.ok()) return {};
  return {choice.name(), bytes_of(buffer), choice.bits == 0 && choice.method == 0, choice.mesh};
}

/// One file for each encoding, speed and set of attributes.
inline std::vector<DracoFile> small_draco_files(const TriangleMesh& shape = draco_shape()) {
  std::vector<DracoFile> files;
  for (int i = 0; i < 2 * 2 * 2 * 2 * 3; ++i) {
    const DracoChoice choice{.mesh = i % 2 == 1,
                             .method = i / 2 % 2,
                             .bits = i / 4 % 2 == 0 ? 0 : 11,
                             .speed = i / 16 * 5,
                             .attributes = i / 8 % 2 == 1};
    DracoFile file = draco_file(shape, choice);
    if (!file.bytes.empty()) files.push_back(std::move(file));
  }
  return files;
}

}  // namespace surfaced::testing
