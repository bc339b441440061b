// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>

#include "base/text.hpp"
#include "io/formats.hpp"
#include "io/scalars.hpp"

namespace surfaced::io {
namespace {

class PlyWriter {
 public:
  PlyWriter(const std::vector<Point3>& positions, const std::vector<Normal3>& normals,
            const std::vector<Color4>& colors, const std::vector<VertexScalar>& scalars)
      : positions_(positions),
        normals_(normals),
        colors_(colors),
        scalars_(scalars),
        narrow_(fits_float32(positions)) {}

  Bytes write(const std::vector<Triangle>* triangles) const {
    const std::string text = header(triangles);
    Bytes bytes;
    bytes.reserve(text.size() + positions_.size() * row_size() + (triangles == nullptr ? 0 : triangles->size() * 13));
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    bytes.insert(bytes.end(), begin, begin + text.size());
    for (std::size_t i = 0; i < positions_.size(); ++i) append_vertex(bytes, i);
    if (triangles == nullptr) return bytes;
    for (const Triangle& t : *triangles) {
      bytes.push_back(std::byte{3});
      for (const VertexIndex v : t) append_little(bytes, v.value);
    }
    return bytes;
  }

 private:
  std::string header(const std::vector<Triangle>* triangles) const {
    const std::string real = narrow_ ? "float" : "double";
    std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(positions_.size()) + "\n";
    for (const char* axis : {"x", "y", "z"}) text += "property " + real + " " + axis + "\n";
    if (!normals_.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (!colors_.empty()) {
      text += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    }
    for (const VertexScalar& scalar : scalars_) text += "property float " + property_of(scalar.name) + "\n";
    if (triangles != nullptr) {
      // int is what every reader expects of an index; uint only where it is needed.
      const bool wide = positions_.size() > 0x7FFFFFFFU;
      text += "element face " + std::to_string(triangles->size()) + "\nproperty list uchar " + (wide ? "uint" : "int") +
              " vertex_indices\n";
    }
    return text + "end_header\n";
  }

  static std::string property_of(const std::string& attribute) {
    return in_lower_case(attribute.substr(attribute.starts_with('_') ? 1 : 0));
  }

  std::size_t row_size() const {
    return (narrow_ ? 12U : 24U) + (normals_.empty() ? 0U : 12U) + (colors_.empty() ? 0U : 4U) + 4 * scalars_.size();
  }

  void append_vertex(Bytes& bytes, std::size_t i) const {
    for (const double x : positions_[i]) {
      if (narrow_) {
        append_little(bytes, static_cast<float>(x));
      } else {
        append_little(bytes, x);
      }
    }
    if (!normals_.empty()) {
      for (const float n : normals_[i]) append_little(bytes, n);
    }
    if (!colors_.empty()) {
      for (const std::uint8_t c : colors_[i]) append_little(bytes, c);
    }
    for (const VertexScalar& scalar : scalars_) append_little(bytes, scalar.values[i]);
  }

  const std::vector<Point3>& positions_;
  const std::vector<Normal3>& normals_;
  const std::vector<Color4>& colors_;
  const std::vector<VertexScalar>& scalars_;
  bool narrow_;
};

}  // namespace

Result<Bytes> write_ply_mesh(const TriangleMesh& mesh, const std::vector<VertexScalar>& scalars) {
  return PlyWriter(mesh.positions, mesh.normals, mesh.colors, scalars).write(&mesh.triangles);
}

}  // namespace surfaced::io

namespace surfaced {

std::vector<std::byte> encode_cloud_ply(const std::vector<Point3>& positions, const std::vector<Normal3>& normals,
                                        const std::vector<Color4>& colors) {
  return io::PlyWriter(positions, normals, colors, {}).write(nullptr);
}

}  // namespace surfaced
