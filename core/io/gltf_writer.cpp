// SPDX-License-Identifier: GPL-3.0-or-later
// Writes glTF and GLB. tinygltf serialises the model; the buffer and `asset.extras` are added here,
// because it copies the buffer three times on the way and its values lose null, large integers and
// the order of fields (README.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "io/gltf_packing.hpp"
#include "io/scalars.hpp"
#include "io/tinygltf.hpp"

namespace surfaced::io {
namespace {

using Json = nlohmann::ordered_json;
using Vector3f = std::array<float, 3>;

/// Largest vertex count that 16-bit indices take; 65535 itself restarts primitives.
constexpr std::size_t kShortIndices = 65535;
/// How far from 1 the squared length of a normal may be that is written as it is: what rounding to
/// float32 leaves of a unit vector.
constexpr double kUnitTolerance = 4 * std::numeric_limits<float>::epsilon();
constexpr std::uint64_t kGlbLimit = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kGlbMagic = 0x46546C67;
constexpr std::uint32_t kGlbJson = 0x4E4F534A;
constexpr std::uint32_t kGlbBinary = 0x004E4942;

std::vector<Vector3f> local_positions(const TriangleMesh& mesh, const Point3& origin) {
  std::vector<Vector3f> local;
  local.reserve(mesh.positions.size());
  for (const Point3& p : mesh.positions) local.push_back(local_position(p, origin));
  return local;
}

/// glTF wants unit normals; empty if one has no direction.
std::vector<Vector3f> unit_normals(const std::vector<Normal3>& normals) {
  std::vector<Vector3f> unit = normals;
  for (Vector3f& n : unit) {
    const Point3 wide{n[0], n[1], n[2]};
    const double squared = dot(wide, wide);
    if (!std::isfinite(squared) || squared == 0) return {};
    if (std::abs(squared - 1) <= kUnitTolerance) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) n[axis] = static_cast<float>(wide[axis] / std::sqrt(squared));
  }
  return unit;
}

/// The model and the bytes its buffer will have.
class ModelBuilder {
 public:
  ModelBuilder(const TriangleMesh& mesh, const EncodeOptions& options)
      : mesh_(mesh),
        options_(options),
        origin_(float_origin_of(mesh.positions)),
        positions_(local_positions(mesh, origin_)),
        normals_(unit_normals(mesh.normals)) {
    model_.asset.version = "2.0";
    model_.asset.generator = "surfaced " SURFACED_VERSION;
    add_primitive();
    add_node();
  }

  const tinygltf::Model& model() const { return model_; }
  std::uint64_t buffer_size() const { return buffer_size_; }
  const std::vector<GltfArray>& arrays() const { return arrays_; }

  /// The mesh as the buffer holds it: around its origin, in float32, with unit normals.
  TriangleMesh stored_mesh() const {
    TriangleMesh stored{.positions = {}, .triangles = mesh_.triangles, .normals = normals_, .colors = mesh_.colors};
    stored.positions.reserve(positions_.size());
    for (const Vector3f& p : positions_) {
      stored.positions.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    return stored;
  }

  void append_buffer(Bytes& bytes) const {
    const std::size_t begin = bytes.size();
    for (const Vector3f& p : positions_) append_vector(bytes, p);
    for (const Vector3f& n : normals_) append_vector(bytes, n);
    for (const Color4& color : mesh_.colors) {
      for (const std::uint8_t c : color) append_little(bytes, c);
    }
    for (const VertexScalar& scalar : options_.scalars) {
      for (const float x : scalar.values) append_little(bytes, x);
    }
    for (const Triangle& t : mesh_.triangles) {
      for (const VertexIndex v : t) {
        if (short_indices()) {
          append_little(bytes, static_cast<std::uint16_t>(v.value));
        } else {
          append_little(bytes, v.value);
        }
      }
    }
    while ((bytes.size() - begin) % 4 != 0) bytes.push_back(std::byte{0});
  }

 private:
  static void append_vector(Bytes& bytes, const Vector3f& v) {
    for (const float x : v) append_little(bytes, x);
  }

  bool short_indices() const { return positions_.size() <= kShortIndices; }

  int add_accessor(int component, int type, std::size_t count, std::size_t size, int target) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer_size_;
    view.byteLength = count * size;
    view.target = target;
    model_.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(accessor);
    arrays_.push_back({static_cast<std::size_t>(buffer_size_), count, size});
    buffer_size_ += (count * size + 3) / 4 * 4;
    return accessor.bufferView;
  }

  void add_primitive() {
    constexpr int kVertices = TINYGLTF_TARGET_ARRAY_BUFFER;
    const std::size_t count = positions_.size();
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    primitive.attributes["POSITION"] =
        add_accessor(TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, count, sizeof(Vector3f), kVertices);
    set_bounds(model_.accessors.back());
    if (!normals_.empty()) {
      primitive.attributes["NORMAL"] =
          add_accessor(TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, count, sizeof(Vector3f), kVertices);
    }
    if (!mesh_.colors.empty()) {
      primitive.attributes["COLOR_0"] =
          add_accessor(TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, count, sizeof(Color4), kVertices);
      model_.accessors.back().normalized = true;
    }
    for (const VertexScalar& scalar : options_.scalars) {
      primitive.attributes[scalar.name] =
          add_accessor(TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, count, sizeof(float), kVertices);
    }
    primitive.indices =
        add_accessor(short_indices() ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                     TINYGLTF_TYPE_SCALAR, 3 * mesh_.triangles.size(), short_indices() ? 2 : 4,
                     TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    tinygltf::Material material;
    material.name = "surface";
    material.doubleSided = true;
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.8;
    model_.materials.push_back(material);
    tinygltf::Mesh mesh;
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
  }

  void set_bounds(tinygltf::Accessor& accessor) const {
    Vector3f low = positions_.front();
    Vector3f high = low;
    for (const Vector3f& p : positions_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    accessor.minValues.assign(low.begin(), low.end());
    accessor.maxValues.assign(high.begin(), high.end());
  }

  void add_node() {
    tinygltf::Node node;
    node.mesh = 0;
    const bool z_up = options_.up == UpAxis::z;
    if (z_up) node.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // a quarter turn about x: z becomes y
    if (origin_ != Point3{}) {
      // The node turns before it moves, so the origin is written turned.
      const Point3 moved = z_up ? Point3{origin_[0], origin_[2], -origin_[1]} : origin_;
      node.translation.assign(moved.begin(), moved.end());
      tinygltf::Value::Array origin;
      for (const double x : origin_) origin.emplace_back(x);
      node.extras = tinygltf::Value(tinygltf::Value::Object{{"origin", tinygltf::Value(origin)}});
    }
    model_.nodes.push_back(node);
    tinygltf::Scene scene;
    scene.nodes.push_back(0);
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
  }

  const TriangleMesh& mesh_;
  const EncodeOptions& options_;
  Point3 origin_;
  std::vector<Vector3f> positions_;
  std::vector<Vector3f> normals_;
  tinygltf::Model model_;
  std::vector<GltfArray> arrays_;
  std::uint64_t buffer_size_ = 0;
};

Result<Json> model_json(const ModelBuilder& builder, const EncodeOptions& options) {
  std::ostringstream text;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&builder.model(), text, false, false)) {
    return Error{ErrorCode::internal_error, "tinygltf could not serialise the mesh"};
  }
  Json json = Json::parse(text.str(), nullptr, false);
  if (json.is_discarded()) return Error{ErrorCode::internal_error, "tinygltf wrote text that is not JSON"};
  if (!options.extras_json.empty()) {
    Json extras = Json::parse(options.extras_json, nullptr, false);
    if (!extras.is_object()) return Error{ErrorCode::internal_error, "extras_json is not a JSON object"};
    json["asset"]["extras"] = std::move(extras);
  }
  json["buffers"] = Json::array({Json{{"byteLength", builder.buffer_size()}}});
  return json;
}

void append_base64(std::string& text, std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t there = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < there ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) text += k <= there ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
  }
}

/// What is written behind the JSON: the arrays of the builder, or what they were packed to.
class Payload {
 public:
  explicit Payload(const ModelBuilder& builder) : builder_(builder) {}

  void replace(Bytes packed) { packed_ = std::move(packed); }
  std::uint64_t size() const { return !packed_.empty() ? packed_.size() : builder_.buffer_size(); }
  void append_to(Bytes& bytes) const {
    if (packed_.empty()) {
      builder_.append_buffer(bytes);
    } else {
      bytes.insert(bytes.end(), packed_.begin(), packed_.end());
    }
  }

 private:
  const ModelBuilder& builder_;
  /// Empty if nothing was packed: what is packed never is.
  Bytes packed_;
};

Result<Bytes> embedded(const Payload& payload, Json json) {
  Bytes buffer;
  buffer.reserve(static_cast<std::size_t>(payload.size()));
  payload.append_to(buffer);
  std::string uri = "data:application/octet-stream;base64,";
  uri.reserve(uri.size() + (buffer.size() + 2) / 3 * 4);
  append_base64(uri, buffer);
  json["buffers"][0]["uri"] = std::move(uri);
  return bytes_of_text(json.dump());
}

Result<Bytes> binary(const Payload& payload, const Json& json) {
  std::string text = json.dump();
  while (text.size() % 4 != 0) text += ' ';
  const std::uint64_t length = 12 + 8 + text.size() + 8 + payload.size();
  if (length > kGlbLimit) {
    return Error{ErrorCode::output_not_writable, "the mesh takes " + std::to_string(length) +
                                                     " bytes as GLB, which holds at most " + std::to_string(kGlbLimit) +
                                                     "; write .ply or .drc"};
  }
  Bytes bytes;
  bytes.reserve(static_cast<std::size_t>(length));
  for (const std::uint32_t word :
       {kGlbMagic, 2U, static_cast<std::uint32_t>(length), static_cast<std::uint32_t>(text.size()), kGlbJson}) {
    append_little(bytes, word);
  }
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  bytes.insert(bytes.end(), begin, begin + text.size());
  append_little(bytes, static_cast<std::uint32_t>(payload.size()));
  append_little(bytes, kGlbBinary);
  payload.append_to(bytes);
  return bytes;
}

/// Packs the builder's buffer as the options ask for.
Status pack(const ModelBuilder& builder, const EncodeOptions& options, Json& json, Payload& payload) {
  if (options.compression == MeshCompression::none) return Done{};
  GltfParts parts{.json = std::move(json), .buffer = {}, .arrays = builder.arrays()};
  builder.append_buffer(parts.buffer);
  const TriangleMesh stored = builder.stored_mesh();
  Status packed = Done{};
  if (options.compression == MeshCompression::draco) {
    packed = pack_with_draco(parts, stored, options);
  } else {
    pack_with_meshopt(parts, stored.triangles, options.quantization_bits);
  }
  json = std::move(parts.json);
  payload.replace(std::move(parts.buffer));
  return packed;
}

}  // namespace

Result<Bytes> write_gltf(const TriangleMesh& mesh, MeshFormat format, const EncodeOptions& options) {
  if (mesh.triangles.empty())
    return Error{ErrorCode::method_failed, "the mesh has no triangles; glTF cannot hold that"};
  const ModelBuilder builder(mesh, options);
  Result<Json> json = model_json(builder, options);
  if (!json) return std::move(json).error();
  Payload payload(builder);
  if (Status packed = pack(builder, options, *json, payload); !packed) return std::move(packed).error();
  return format == MeshFormat::glb ? binary(payload, *json) : embedded(payload, std::move(*json));
}

}  // namespace surfaced::io
