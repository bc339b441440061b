// SPDX-License-Identifier: GPL-3.0-or-later
#include <draco/attributes/point_attribute.h>

#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "io/colors.hpp"
#include "io/draco_guard.hpp"
#include "io/formats.hpp"

namespace surfaced::io {
namespace {

using draco::AttributeValueIndex;
using draco::PointAttribute;
using draco::PointIndex;

/// Takes attributes out of a decoded file. Nothing says that Draco filled them: every index is checked.
class AttributeReader {
 public:
  AttributeReader(const draco::PointCloud& cloud, std::string_view name) : cloud_(cloud), name_(name) {}

  /// Values of an attribute by point.
  template <class T, std::size_t N>
  Status read(const PointAttribute& attribute, std::vector<std::array<T, N>>& values) const {
    if (Status status = check(attribute); !status) return status;
    values.resize(cloud_.num_points());
    if (!copy_floats(attribute, values)) {
      for (std::uint32_t i = 0; i < cloud_.num_points(); ++i) {
        if (!attribute.ConvertValue<T>(attribute.mapped_index(PointIndex(i)), static_cast<std::int8_t>(N),
                                       values[i].data())) {
          return malformed("the value of point " + std::to_string(i) + " cannot be converted");
        }
      }
    }
    return Done{};
  }

  Error malformed(const std::string& what) const {
    return {ErrorCode::malformed_input, std::string(name_) + ": " + what};
  }

 private:
  Status check(const PointAttribute& attribute) const {
    if (attribute.data_type() == draco::DT_BOOL) {
      return Error{ErrorCode::unsupported_feature, std::string(name_) + ": an attribute of type bool"};
    }
    const std::size_t there = attribute.buffer() == nullptr || attribute.byte_stride() <= 0
                                  ? 0
                                  : attribute.buffer()->data_size() / static_cast<std::size_t>(attribute.byte_stride());
    const std::size_t values = std::min(there, attribute.size());
    const std::uint32_t points = cloud_.num_points();
    if (attribute.is_mapping_identity()) {
      return points <= values ? Status(Done{}) : Status(too_short(values));
    }
    if (attribute.indices_map_size() < points) return too_short(attribute.indices_map_size());
    for (std::uint32_t i = 0; i < points; ++i) {
      if (attribute.mapped_index(PointIndex(i)).value() >= values) return too_short(values);
    }
    return Done{};
  }

  Error too_short(std::size_t values) const {
    return malformed("an attribute has " + std::to_string(values) + " values for " +
                     std::to_string(cloud_.num_points()) + " points");
  }

  /// The common case without conversion; false if it is another one.
  template <class T, std::size_t N>
  bool copy_floats(const PointAttribute& attribute, std::vector<std::array<T, N>>& values) const {
    if (attribute.data_type() != draco::DT_FLOAT32 || attribute.num_components() != N ||
        !attribute.is_mapping_identity()) {
      return false;
    }
    for (std::uint32_t i = 0; i < cloud_.num_points(); ++i) {
      std::array<float, N> stored;
      std::memcpy(stored.data(), attribute.GetAddress(AttributeValueIndex(i)), sizeof(stored));
      for (std::size_t c = 0; c < N; ++c) values[i][c] = static_cast<T>(stored[c]);
    }
    return true;
  }

  const draco::PointCloud& cloud_;
  std::string_view name_;
};

/// Attributes of a file by what they are, or by the ids that a glTF gives.
struct Chosen {
  const PointAttribute* position = nullptr;
  const PointAttribute* normal = nullptr;
  const PointAttribute* color = nullptr;
};

Chosen choose(const draco::PointCloud& cloud, const std::optional<DracoIds>& ids) {
  if (!ids) {
    return {cloud.GetNamedAttribute(PointAttribute::POSITION), cloud.GetNamedAttribute(PointAttribute::NORMAL),
            cloud.GetNamedAttribute(PointAttribute::COLOR)};
  }
  const auto by_id = [&](const std::optional<std::uint32_t>& id) {
    return id ? cloud.GetAttributeByUniqueId(*id) : nullptr;
  };
  return {by_id(ids->position), by_id(ids->normal), by_id(ids->color)};
}

Status read_colors(const AttributeReader& reader, const PointAttribute& attribute, RawCloud& cloud) {
  if (attribute.num_components() < 3) {
    cloud.warnings.push_back("colours ignored: " + std::to_string(attribute.num_components()) + " components");
    return Done{};
  }
  const bool alpha = attribute.num_components() >= 4;
  std::vector<WideColor> wide;
  if (Status status = reader.read(attribute, wide); !status) return status;
  const bool floating = attribute.data_type() == draco::DT_FLOAT32 || attribute.data_type() == draco::DT_FLOAT64;
  if (!floating && attribute.normalized()) {  // Draco has divided them by the largest value of their type
    for (WideColor& color : wide) {
      for (float& channel : color) channel *= 255;
    }
  }
  cloud.colors = to_bytes(wide, floating, alpha, cloud.warnings);
  return Done{};
}

Result<RawCloud> read_points(const draco::PointCloud& points, const Chosen& chosen, std::string_view name) {
  if (chosen.position == nullptr || chosen.position->num_components() != 3) {
    return Error{ErrorCode::missing_positions, std::string(name) + ": the Draco file has " +
                                                   std::to_string(points.num_attributes()) +
                                                   " attributes, none of them a POSITION of 3 components"};
  }
  const AttributeReader reader(points, name);
  RawCloud cloud;
  if (Status status = reader.read(*chosen.position, cloud.positions); !status) return std::move(status).error();
  if (chosen.normal != nullptr && chosen.normal->num_components() == 3) {
    if (Status status = reader.read(*chosen.normal, cloud.normals); !status) return std::move(status).error();
  }
  if (chosen.color != nullptr) {
    if (Status status = read_colors(reader, *chosen.color, cloud); !status) return std::move(status).error();
  }
  return cloud;
}

Status read_triangles(const draco::Mesh& mesh, std::string_view name, std::vector<Triangle>& triangles,
                      std::vector<std::string>& warnings) {
  std::size_t degenerate = 0;
  triangles.reserve(mesh.num_faces());
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    for (const PointIndex& p : face) {
      if (p.value() < mesh.num_points()) continue;
      return Error{ErrorCode::malformed_input, std::string(name) + ": triangle " + std::to_string(f) +
                                                   " refers to point " + std::to_string(p.value()) + " of " +
                                                   std::to_string(mesh.num_points())};
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      ++degenerate;
    } else {
      triangles.push_back({VertexIndex(face[0].value()), VertexIndex(face[1].value()), VertexIndex(face[2].value())});
    }
  }
  warn_of_degenerate(degenerate, warnings);
  return Done{};
}

}  // namespace

Result<RawCloud> read_draco_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits) {
  const Result<DracoGeometry> geometry = decode_draco(bytes, name, limits.max_points);
  if (!geometry) return geometry.error();
  Result<RawCloud> cloud = read_points(*geometry->points, choose(*geometry->points, {}), name);
  if (cloud && geometry->mesh != nullptr) cloud->source.faces = geometry->mesh->num_faces();
  return cloud;
}

Result<TriangleMesh> read_draco_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const std::optional<DracoIds>& ids, std::vector<std::string>& warnings) {
  const Result<DracoGeometry> geometry = decode_draco(bytes, name, ReadLimits{}.max_points);
  if (!geometry) return geometry.error();
  if (geometry->mesh == nullptr) {
    return Error{ErrorCode::unsupported_feature, std::string(name) + ": the Draco file holds a cloud, not a mesh"};
  }
  Result<RawCloud> cloud = read_points(*geometry->points, choose(*geometry->points, ids), name);
  if (!cloud) return std::move(cloud).error();
  warnings.insert(warnings.end(), cloud->warnings.begin(), cloud->warnings.end());
  TriangleMesh mesh;
  if (Status status = read_triangles(*geometry->mesh, name, mesh.triangles, warnings); !status) {
    return std::move(status).error();
  }
  mesh.positions = std::move(cloud->positions);
  mesh.normals = std::move(cloud->normals);
  mesh.colors = std::move(cloud->colors);
  return mesh;
}

}  // namespace surfaced::io
