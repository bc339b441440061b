// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the triangles of a glTF scene. tinygltf is not used for this: it follows nested extras
// recursively until the stack ends, reads files that a URI names, and refuses the normal form of
// KHR_draco_mesh_compression (README.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "io/gltf_container.hpp"
#include "io/gltf_elements.hpp"
#include "io/gltf_transform.hpp"
#include "io/meshopt.hpp"
#include "io/scalars.hpp"
#include "io/text.hpp"

namespace surfaced::io {
namespace {

using Json = nlohmann::json;

/// Accessors may be shared and meshes instanced, so a small file can ask for any number of triangles:
/// more than these per byte are refused; a small file may ask for as many as one of 64 KiB.
constexpr std::uint64_t kVerticesPerByte = 2;
constexpr std::uint64_t kTrianglesPerByte = 4;
constexpr std::uint64_t kSmallGltf = std::uint64_t{1} << 16;

constexpr std::string_view kQuantizationExtension = "KHR_mesh_quantization";
constexpr std::string_view kDracoExtension = "KHR_draco_mesh_compression";

enum Mode { kTriangles = 4, kStrip = 5, kFan = 6 };

std::size_t index_at(const Elements& indices, std::size_t i) {
  const std::byte* at = indices.at(i);
  switch (indices.component_type) {
    case kUnsignedByte:
      return load_little<std::uint8_t>(at);
    case kUnsignedShort:
      return load_little<std::uint16_t>(at);
    default:
      return load_little<std::uint32_t>(at);
  }
}

/// What is taken of a scene: its triangles, or the vertices of whatever it shows.
enum class Taken : std::uint8_t { triangles, points };

/// Walks a scene and joins its primitives into one mesh.
class SceneReader {
 public:
  SceneReader(const GltfDocument& document, std::size_t file_size, Taken taken, std::vector<std::string>& warnings)
      : document_(document),
        taken_(taken),
        most_vertices_(std::min<std::uint64_t>(kVerticesPerByte * std::max<std::uint64_t>(file_size, kSmallGltf),
                                               VertexIndex::kNone)),
        most_triangles_(kTrianglesPerByte * std::max<std::uint64_t>(file_size, kSmallGltf)),
        warnings_(warnings) {}

  /// Triangles, whether or not they are taken.
  std::uint64_t faces() const { return faces_; }

  TriangleMesh run() {
    check_extensions();
    struct Visit {
      std::uint64_t node;
      Affine parent;
    };
    const Json& nodes = document_.member(document_.json(), "nodes");
    std::vector<bool> seen(nodes.is_array() ? nodes.size() : 0, false);
    std::vector<Visit> stack;
    for (const std::uint64_t root : roots()) stack.push_back({root, {}});
    std::ranges::reverse(stack);
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const Json& node = document_.entry("nodes", visit.node);
      if (seen[static_cast<std::size_t>(visit.node)]) {
        document_.malformed("node " + std::to_string(visit.node) + " has two parents");
      }
      seen[static_cast<std::size_t>(visit.node)] = true;
      const Affine transform = visit.parent.after(transform_of(document_, node));
      if (const Json& mesh = document_.member(node, "mesh"); !mesh.is_null()) {
        add_mesh(document_.whole(mesh, "mesh of a node"), transform);
      }
      const std::vector<std::uint64_t> children = indices_in(document_.member(node, "children"));
      for (std::size_t i = children.size(); i-- > 0;) stack.push_back({children[i], transform});
    }
    finish();
    return std::move(mesh_);
  }

 private:
  void check_extensions() const {
    const Json& required = document_.member(document_.json(), "extensionsRequired");
    if (!required.is_array()) return;
    for (const Json& extension : required) {
      const std::string name = extension.is_string() ? extension.get<std::string>() : "?";
      const bool harmless = name == kDracoExtension || name == kMeshoptExtension || name == kQuantizationExtension ||
                            name.starts_with("KHR_materials_") || name.starts_with("KHR_texture_");
      if (!harmless) document_.unsupported("it requires the extension " + in_quotes(name));
    }
  }

  std::vector<std::uint64_t> indices_in(const Json& array) const {
    std::vector<std::uint64_t> indices;
    if (array.is_null()) return indices;
    if (!array.is_array()) document_.malformed("an array of indices was expected");
    for (const Json& index : array) indices.push_back(document_.whole(index, "an index"));
    return indices;
  }

  /// Roots of the scene shown by default; without scenes, all nodes that are nobody's children.
  std::vector<std::uint64_t> roots() const {
    const Json& json = document_.json();
    if (const Json& scenes = document_.member(json, "scenes"); scenes.is_array() && !scenes.empty()) {
      const std::uint64_t shown = document_.whole(json, "scene", 0);
      return indices_in(document_.member(document_.entry("scenes", shown), "nodes"));
    }
    const Json& nodes = document_.member(json, "nodes");
    const std::size_t count = nodes.is_array() ? nodes.size() : 0;
    std::vector<bool> child(count, false);
    for (std::size_t i = 0; i < count; ++i) {
      for (const std::uint64_t c : indices_in(document_.member(nodes[i], "children"))) {
        if (c < count) child[static_cast<std::size_t>(c)] = true;
      }
    }
    std::vector<std::uint64_t> roots;
    for (std::size_t i = 0; i < count; ++i) {
      if (!child[i]) roots.push_back(i);
    }
    return roots;
  }

  struct VertexSpan {
    std::size_t first = 0;
    std::size_t count = 0;
  };

  void add_mesh(std::uint64_t index, const Affine& transform) {
    const Json& primitives = document_.member(document_.entry("meshes", index), "primitives");
    if (!primitives.is_array()) document_.malformed("meshes[" + std::to_string(index) + "] has no primitives");
    shared_.clear();
    for (const Json& primitive : primitives) add_primitive(primitive, transform);
  }

  void add_primitive(const Json& primitive, const Affine& transform) {
    const std::uint64_t mode = document_.whole(primitive, "mode", kTriangles);
    if (taken_ == Taken::triangles && (mode < kTriangles || mode > kFan)) {
      ++without_triangles_;
      return;
    }
    const Json& extensions = document_.member(primitive, "extensions");
    if (extensions.is_object() && extensions.contains(kDracoExtension)) {
      add_draco(document_.member(extensions, kDracoExtension), transform);
      return;
    }
    const VertexSpan vertices = add_vertices(document_.member(primitive, "attributes"), transform);
    if (taken_ == Taken::points) {
      faces_ +=
          mode >= kTriangles && mode <= kFan ? faces_of(document_.member(primitive, "indices"), mode, vertices) : 0;
      return;
    }
    add_triangles(document_.member(primitive, "indices"), mode, vertices, transform.determinant() < 0);
  }

  /// Triangles of a primitive whose vertices alone are taken.
  std::uint64_t faces_of(const Json& indices_of, std::uint64_t mode, const VertexSpan& vertices) const {
    const std::size_t corners =
        indices_of.is_null() ? vertices.count : document_.accessor(document_.whole(indices_of, "indices")).count;
    return mode == kTriangles ? corners / 3 : corners < 3 ? 0 : corners - 2;
  }

  /// KHR_draco_mesh_compression: the primitive's triangles and attributes lie in a Draco file.
  void add_draco(const Json& extension, const Affine& transform) {
    const std::span<const std::byte> bytes =
        document_.buffer_view(document_.whole(document_.member(extension, "bufferView"), "bufferView"));
    const Json& attributes = document_.member(extension, "attributes");
    const auto id = [&](std::string_view name) -> std::optional<std::uint32_t> {
      const Json& value = document_.member(attributes, name);
      if (value.is_null()) return std::nullopt;
      return static_cast<std::uint32_t>(document_.whole(value, name));
    };
    const DracoIds ids{id("POSITION"), id("NORMAL"), id("COLOR_0")};
    Result<TriangleMesh> part = read_draco_mesh(bytes, document_.name(), ids, warnings_);
    if (!part) throw Refusal{std::move(part).error()};
    if (part->positions.size() > most_vertices_ - mesh_.positions.size()) too_many("vertices", most_vertices_);
    if (part->triangles.size() > most_triangles_ - mesh_.triangles.size()) too_many("triangles", most_triangles_);
    const std::size_t first = mesh_.positions.size();
    for (const Point3& p : part->positions) mesh_.positions.push_back(transform(p));
    for (const Normal3& n : part->normals) push_normal(n, transform);
    mesh_.colors.insert(mesh_.colors.end(), part->colors.begin(), part->colors.end());
    faces_ += part->triangles.size();
    normals_missing_ |= part->normals.empty();
    colors_missing_ |= part->colors.empty();
    for (Triangle t : part->triangles) {
      if (transform.determinant() < 0) std::swap(t[1], t[2]);
      mesh_.triangles.push_back({VertexIndex(first + t[0]), VertexIndex(first + t[1]), VertexIndex(first + t[2])});
    }
  }

  /// Primitives of a mesh that share their attributes share the vertices too.
  VertexSpan add_vertices(const Json& attributes, const Affine& transform) {
    std::array<std::optional<std::uint64_t>, 3> key;
    constexpr std::array<std::string_view, 3> kNames{"POSITION", "NORMAL", "COLOR_0"};
    for (std::size_t i = 0; i < key.size(); ++i) {
      const Json& accessor = document_.member(attributes, kNames.at(i));
      if (!accessor.is_null()) key.at(i) = document_.whole(accessor, kNames.at(i));
    }
    if (!key[0]) document_.refuse(ErrorCode::missing_positions, "a primitive has no attribute POSITION");
    const auto [known, is_new] = shared_.try_emplace(key);
    if (!is_new) return known->second;
    const Elements positions = document_.accessor(*key[0]);
    VertexSpan& span = known->second;
    span = {mesh_.positions.size(), positions.count};
    if (positions.count > most_vertices_ - span.first) too_many("vertices", most_vertices_);
    add_positions(positions, transform);
    add_normals(key[1], span.count, transform);
    add_colors(key[2], span.count);
    return span;
  }

  void add_positions(const Elements& positions, const Affine& transform) {
    if ((positions.component_type != kFloat && !is_quantised(positions.component_type)) || positions.components != 3)
      document_.unsupported("POSITION is not VEC3 of float, or of 8 or 16 bits as KHR_mesh_quantization has them");
    for (std::size_t i = 0; i < positions.count; ++i) {
      mesh_.positions.push_back(
          transform({component_at(positions, i, 0), component_at(positions, i, 1), component_at(positions, i, 2)}));
    }
  }

  void add_normals(std::optional<std::uint64_t> accessor, std::size_t count, const Affine& transform) {
    if (!accessor) {
      normals_missing_ = true;
      return;
    }
    const Elements normals = document_.accessor(*accessor);
    const bool quantised = normals.component_type == kByte || normals.component_type == kShort;
    if ((normals.component_type != kFloat && !quantised) || normals.components != 3)
      document_.unsupported("NORMAL is not VEC3 of float, or of signed integers as KHR_mesh_quantization has them");
    if (normals.count != count) document_.malformed("NORMAL and POSITION differ in length");
    for (std::size_t i = 0; i < count; ++i) {
      const auto part = [&](std::size_t c) { return static_cast<float>(component_at(normals, i, c)); };
      push_normal({part(0), part(1), part(2)}, transform);
    }
  }

  void push_normal(const Normal3& normal, const Affine& transform) {
    if (transform.only_shifts()) {
      mesh_.normals.push_back(normal);
      return;
    }
    const Point3 turned = transform.cofactors().turn({normal[0], normal[1], normal[2]});
    const double length = norm(turned);
    const double scale = length > 0 ? 1 / length : 1;
    mesh_.normals.push_back({static_cast<float>(scale * turned[0]), static_cast<float>(scale * turned[1]),
                             static_cast<float>(scale * turned[2])});
  }

  void add_colors(std::optional<std::uint64_t> accessor, std::size_t count) {
    if (!accessor) {
      colors_missing_ = true;
      return;
    }
    const Elements colors = document_.accessor(*accessor);
    const bool known_type = colors.component_type == kUnsignedByte || colors.component_type == kUnsignedShort ||
                            colors.component_type == kFloat;
    if (!known_type || colors.components < 3) document_.unsupported("COLOR_0 is not VEC3 or VEC4 of a colour type");
    if (colors.count != count) document_.malformed("COLOR_0 and POSITION differ in length");
    const double full = full_scale(colors.component_type);
    for (std::size_t i = 0; i < count; ++i) {
      Color4 color{0, 0, 0, 255};
      for (std::size_t c = 0; c < colors.components; ++c) {
        const double value = stored_at(colors, i, c) / full * 255;
        color[c] = static_cast<std::uint8_t>(value >= 0 ? std::min(std::round(value), 255.0) : 0);  // NaN is 0
      }
      mesh_.colors.push_back(color);
    }
  }

  void add_triangles(const Json& indices_of, std::uint64_t mode, const VertexSpan& vertices, bool mirrored) {
    std::optional<Elements> indices;
    if (!indices_of.is_null()) {
      indices = document_.accessor(document_.whole(indices_of, "indices"));
      const bool known_type = indices->component_type == kUnsignedByte || indices->component_type == kUnsignedShort ||
                              indices->component_type == kUnsignedInt;
      if (!known_type || indices->components != 1) document_.malformed("indices are not unsigned scalars");
    }
    const std::size_t corners = indices ? indices->count : vertices.count;
    if (mode == kTriangles && corners % 3 != 0) {
      document_.malformed(std::to_string(corners) + " indices make no whole number of triangles");
    }
    const std::size_t count = mode == kTriangles ? corners / 3 : corners < 3 ? 0 : corners - 2;
    if (count > most_triangles_ - mesh_.triangles.size()) too_many("triangles", most_triangles_);
    const auto vertex = [&](std::size_t corner) {
      const std::size_t v = indices ? index_at(*indices, corner) : corner;
      if (v >= vertices.count) {
        document_.malformed("index " + std::to_string(corner) + " is " + std::to_string(v) + "; there are " +
                            std::to_string(vertices.count) + " vertices");
      }
      return VertexIndex(vertices.first + v);
    };
    for (std::size_t t = 0; t < count; ++t) {
      Triangle triangle = mode == kTriangles ? Triangle{vertex(3 * t), vertex(3 * t + 1), vertex(3 * t + 2)}
                          : mode == kFan     ? Triangle{vertex(0), vertex(t + 1), vertex(t + 2)}
                          : t % 2 == 0       ? Triangle{vertex(t), vertex(t + 1), vertex(t + 2)}
                                             : Triangle{vertex(t + 1), vertex(t), vertex(t + 2)};
      if (mirrored) std::swap(triangle[1], triangle[2]);
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
        ++degenerate_;
      } else {
        mesh_.triangles.push_back(triangle);
      }
    }
  }

  [[noreturn]] void too_many(const char* what, std::uint64_t limit) const {
    document_.unsupported(std::string("shared accessors and instances make more ") + what + " than " +
                          std::to_string(limit) + ", the limit for a file of this size");
  }

  void finish() {
    if (mesh_.positions.empty()) {
      document_.refuse(ErrorCode::empty_input,
                       taken_ == Taken::triangles ? "the scene has no triangles" : "the scene has no points");
    }
    if (normals_missing_ && !mesh_.normals.empty()) warnings_.emplace_back("normals dropped: not all parts have them");
    if (colors_missing_ && !mesh_.colors.empty()) warnings_.emplace_back("colours dropped: not all parts have them");
    if (normals_missing_) mesh_.normals.clear();
    if (colors_missing_) mesh_.colors.clear();
    if (without_triangles_ > 0) {
      warnings_.push_back(std::to_string(without_triangles_) + " primitives of points or lines left out");
    }
    warn_of_degenerate(degenerate_, warnings_);
  }

  const GltfDocument& document_;
  Taken taken_;
  std::uint64_t most_vertices_;
  std::uint64_t most_triangles_;
  std::vector<std::string>& warnings_;
  TriangleMesh mesh_;
  std::map<std::array<std::optional<std::uint64_t>, 3>, VertexSpan> shared_;
  std::size_t degenerate_ = 0;
  std::uint64_t faces_ = 0;
  std::size_t without_triangles_ = 0;
  bool normals_missing_ = false;
  bool colors_missing_ = false;
};

}  // namespace

Result<TriangleMesh> read_gltf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                    std::vector<std::string>& warnings, const Beside& beside) {
  try {
    const GltfDocument document(bytes, name, beside);
    return SceneReader(document, document.size(), Taken::triangles, warnings).run();
  } catch (Refusal& refusal) {
    return std::move(refusal.error);
  }
}

Result<RawCloud> read_gltf_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits,
                                 const Beside& beside) {
  try {
    RawCloud cloud;
    const GltfDocument document(bytes, name, beside);
    SceneReader reader(document, document.size(), Taken::points, cloud.warnings);
    TriangleMesh mesh = reader.run();
    cloud.source.faces = reader.faces();
    if (mesh.positions.size() > most_points(limits)) return too_many(name, mesh.positions.size(), most_points(limits));
    cloud.positions = std::move(mesh.positions);
    cloud.normals = std::move(mesh.normals);
    cloud.colors = std::move(mesh.colors);
    return cloud;
  } catch (Refusal& refusal) {
    return std::move(refusal.error);
  }
}

}  // namespace surfaced::io
