// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "io/io.hpp"
#include "support/draco_files.hpp"
#include "support/glb_files.hpp"
#include "support/limited_child.hpp"
#include "support/ply_files.hpp"
#include "support/results.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::AnyOf;
using ::testing::HasSubstr;

Glb glb_of(const TriangleMesh& mesh, const EncodeOptions& options = {}) {
  return take_apart(encode_mesh(mesh, MeshFormat::glb, options).value());
}

EncodeOptions with_up(UpAxis up) { return {.quantization_bits = {}, .up = up, .extras_json = {}}; }

TEST(GltfWriter, says_who_wrote_it_and_carries_the_extras_unchanged) {
  const std::string extras = R"({"z":null,"a":[1,null,{"big":9007199254740993,"x":0.1}],"m":{"b":true,"a":"ü"}})";
  const Glb glb = glb_of(tetrahedron(), {.quantization_bits = {}, .up = UpAxis::y, .extras_json = extras});
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  EXPECT_THAT(glb.json["asset"]["generator"].get<std::string>(), ::testing::StartsWith("surfaced "));
  EXPECT_EQ(glb.json["asset"]["extras"].dump(), extras);
  EXPECT_FALSE(glb_of(tetrahedron()).json["asset"].contains("extras"));
}

TEST(GltfWriter, refuses_extras_that_are_no_object) {
  for (const char* extras : {"[1]", "{", "3"}) {
    EXPECT_EQ(code_of(encode_mesh(tetrahedron(), MeshFormat::glb,
                                  {.quantization_bits = {}, .up = UpAxis::y, .extras_json = extras})),
              "internal_error");
  }
}

TEST(GltfWriter, uses_the_smallest_indices_that_reach_every_vertex) {
  const auto component = [](std::size_t vertices) {
    TriangleMesh mesh;
    for (std::size_t i = 0; i < vertices; ++i)
      mesh.positions.push_back({static_cast<double>(i), static_cast<double>(i * i % 7), 0});
    mesh.triangles = {triangle(0, 1, vertices - 1)};
    const Glb glb = glb_of(mesh);
    return glb.json["accessors"][glb.json["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()]["componentType"]
        .get<int>();
  };
  EXPECT_EQ(component(3), 5123);
  EXPECT_EQ(component(65535), 5123);
  EXPECT_EQ(component(65536), 5125);  // 65535 as an index restarts a primitive
}

TEST(GltfWriter, bounds_of_positions_are_exact) {
  TriangleMesh mesh = torus_mesh(9, 7);
  for (Point3& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x + 0.1));
  }
  const Bounds bounds = bounds_of(mesh.positions);
  const Json accessor = glb_of(mesh).json["accessors"][0];
  EXPECT_EQ(accessor["min"].get<Point3>(), bounds.low);
  EXPECT_EQ(accessor["max"].get<Point3>(), bounds.high);
}

TEST(GltfWriter, everything_is_aligned_to_four_bytes) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.pop_back();  // 9 short indices: 18 bytes
  mesh.colors.assign(4, Color4{1, 2, 3, 4});
  const std::vector<std::byte> bytes = encode_mesh(mesh, MeshFormat::glb).value();
  const Glb glb = take_apart(bytes);
  EXPECT_EQ(word_at(bytes, 8), bytes.size());
  EXPECT_EQ(bytes.size() % 4, 0U);
  for (const Json& view : glb.json["bufferViews"]) EXPECT_EQ(view.value("byteOffset", 0) % 4, 0);
  EXPECT_EQ(glb.json["buffers"][0]["byteLength"], glb.binary.size());
}

TEST(GltfWriter, makes_normals_unit_and_leaves_out_those_without_direction) {
  TriangleMesh mesh = tetrahedron();
  mesh.normals = {{0, 0, 3}, {0, 0.6F, 0.8F}, {1e-30F, 0, 0}, {0, -7e18F, 0}};
  const auto back = decode_mesh(encode_mesh(mesh, MeshFormat::glb).value(), "mesh");
  EXPECT_EQ(back.value().normals, (std::vector<Normal3>{{0, 0, 1}, {0, 0.6F, 0.8F}, {1, 0, 0}, {0, -1, 0}}));
  mesh.normals[1] = {0, 0, 0};
  EXPECT_FALSE(glb_of(mesh).json["meshes"][0]["primitives"][0]["attributes"].contains("NORMAL"));
}

TEST(GltfWriter, keeps_the_origin_of_doubles_in_translation_and_extras) {
  TriangleMesh mesh = tetrahedron();
  for (Point3& p : mesh.positions) p = {p[0] + 412345.678, p[1] + 5654321.123, p[2] + 0.1};
  for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
    const Json node = glb_of(mesh, with_up(up)).json["nodes"][0];
    const auto origin = node["extras"]["origin"].get<Point3>();
    const auto moved = node["translation"].get<Point3>();
    EXPECT_EQ(moved, up == UpAxis::y ? origin : (Point3{origin[0], origin[2], -origin[1]}));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(origin[axis], mesh.positions[0][axis], 2);
      EXPECT_EQ(static_cast<double>(static_cast<float>(origin[axis])), origin[axis])
          << "float32 readers get it exactly";
    }
    EXPECT_EQ(node.contains("rotation"), up == UpAxis::z);
  }
  EXPECT_FALSE(glb_of(tetrahedron()).json["nodes"][0].contains("translation"));
}

TEST(GltfWriter, up_z_turns_z_to_y) {
  const Json node = glb_of(tetrahedron(), with_up(UpAxis::z)).json["nodes"][0];
  const auto q = node["rotation"].get<std::array<double, 4>>();
  // Rotation of (0, 0, 1) by the quaternion.
  const Point3 turned{2 * (q[0] * q[2] + q[1] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
                      1 - 2 * (q[0] * q[0] + q[1] * q[1])};
  EXPECT_NEAR(turned[0], 0, 1e-15);
  EXPECT_NEAR(turned[1], 1, 1e-15);
  EXPECT_NEAR(turned[2], 0, 1e-15);
}

TEST(GltfReader, applies_the_transforms_of_nodes_and_keeps_mirrored_triangles_facing_the_same_way) {
  const auto mesh = decode_mesh(testing::as_bytes(kTwoNodes), "nodes.gltf");
  ASSERT_TRUE(mesh.ok()) << detail_of(mesh);
  EXPECT_EQ(mesh->positions[0], (Point3{1, 2, 3}));
  EXPECT_EQ(mesh->positions[4], (Point3{11, 2, 3}));
  EXPECT_EQ(mesh->positions[5], (Point3{10, 2, 3}));
  ASSERT_EQ(mesh->triangles.size(), 4U);
  const auto facing = [&](const Triangle& t) {
    return cross(mesh->positions[t[1]] - mesh->positions[t[0]], mesh->positions[t[2]] - mesh->positions[t[0]])[2];
  };
  for (const Triangle& t : mesh->triangles) EXPECT_GT(facing(t), 0);
}

TEST(GltfReader, reads_a_glb_whose_triangles_are_draco_compressed_in_the_normal_form) {
  for (const DracoFile& file : small_draco_files()) {
    if (!file.mesh) continue;
    Glb glb;
    glb.binary.assign(reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size());
    glb.binary.resize((glb.binary.size() + 3) / 4 * 4);
    glb.json = Json::parse(R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"],
      "extensionsUsed":["KHR_draco_mesh_compression"],"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[0,0,5]}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"extensions":{"KHR_draco_mesh_compression":
      {"bufferView":0,"attributes":{"POSITION":0}}}}]}],"accessors":[{"componentType":5126,"type":"VEC3","count":63},
      {"componentType":5123,"type":"SCALAR","count":378}]})");
    glb.json["bufferViews"] = Json::array({Json{{"buffer", 0}, {"byteLength", file.bytes.size()}}});
    glb.json["buffers"] = Json::array({Json{{"byteLength", glb.binary.size()}}});
    const auto mesh = decode_mesh(put_together(glb), file.name);
    ASSERT_TRUE(mesh.ok()) << file.name << ": " << detail_of(mesh);
    const auto plain = decode_mesh(file.bytes, file.name);
    EXPECT_EQ(mesh->triangles, plain->triangles);
    for (std::size_t i = 0; i < plain->positions.size(); ++i) {
      EXPECT_EQ(mesh->positions[i][2], plain->positions[i][2] + 5);
    }
  }
}

struct Damage {
  std::string what;
  std::function<void(Glb&)> change;
  std::string code;
  std::string detail;
};

std::vector<Damage> damages() {
  const auto set = [](const char* pointer, const Json& value) {
    return [=](Glb& glb) { glb.json[Json::json_pointer(pointer)] = value; };
  };
  const auto erase = [](const char* key) { return [=](Glb& glb) { glb.json.erase(key); }; };
  return {
      {"a short buffer", [](Glb& glb) { glb.binary.resize(4); }, "truncated_input", "4 are there"},
      {"a view beyond the buffer", set("/bufferViews/0/byteLength", 1 << 30), "malformed_input", "bufferViews[0]"},
      {"an offset that overflows", set("/bufferViews/0/byteOffset", 0xFFFFFFFFFFFFFFFFU), "malformed_input",
       "bufferViews[0]"},
      {"2^40 positions", set("/accessors/0/count", std::uint64_t{1} << 40), "malformed_input", "1099511627776"},
      {"an accessor offset beyond its view", set("/accessors/0/byteOffset", 1000), "malformed_input", "room for 0"},
      {"a stride of 0", set("/bufferViews/0/byteStride", 0), "malformed_input", "byteStride"},
      {"a negative count", set("/accessors/0/count", -4), "malformed_input", "count"},
      {"a fractional count", set("/accessors/0/count", 1.5), "malformed_input", "count"},
      {"an unknown component type", set("/accessors/0/componentType", 5124), "malformed_input", "5124"},
      {"positions of two numbers", set("/accessors/0/type", "VEC2"), "unsupported_feature", "POSITION"},
      {"matrices", set("/accessors/0/type", "MAT4"), "unsupported_feature", "VEC2"},
      {"a sparse accessor", set("/accessors/0/sparse", Json::object()), "unsupported_feature", "sparse"},
      {"an index beyond the vertices", [](Glb& glb) { glb.binary[48] = 4; }, "malformed_input", "is 4"},
      {"a missing accessor", set("/meshes/0/primitives/0/indices", 7), "malformed_input", "accessors[7]"},
      {"a buffer elsewhere", set("/buffers/0/uri", "file:///etc/passwd"), "unsupported_feature", "another file"},
      {"a buffer of another data URI", set("/buffers/0/uri", "data:text/plain,hello"), "unsupported_feature", "base64"},
      {"a buffer of bad base64", set("/buffers/0/uri", "data:;base64,ab!d"), "malformed_input", "base64"},
      {"an unknown extension", set("/extensionsRequired", {"KHR_none_such"}), "unsupported_feature", "KHR_none_such"},
      {"a node twice", set("/scenes/0/nodes", {0, 0}), "malformed_input", "two parents"},
      {"a node that is its own child", set("/nodes/0/children", {0}), "malformed_input", "two parents"},
      {"a node that is not there", set("/scenes/0/nodes", {3}), "malformed_input", "nodes[3]"},
      {"no asset", erase("asset"), "unknown_format", "asset"},
      {"version 1", set("/asset/version", "1.0"), "unsupported_feature", "'1.0'"},
      {"no scene content", erase("nodes"), "malformed_input", "nodes[0]"},
      {"an empty scene", set("/scenes/0/nodes", Json::array()), "empty_input", "no triangles"},
      {"only lines", set("/meshes/0/primitives/0/mode", 1), "empty_input", "no triangles"},
      {"a scene of numbers", set("/scenes/0", 5), "malformed_input", "nodes"},
      {"meshes that are text", set("/meshes", "none"), "malformed_input", "meshes[0]"},
      {"a translation of text", set("/nodes/0/translation", "far"), "malformed_input", "translation"},
  };
}

TEST(GltfHostile, every_damage_is_refused_with_its_code_and_the_reason) {
  const Glb good = glb_of(tetrahedron());
  ASSERT_EQ(code_of(decode_mesh(put_together(good), "good")), "ok");
  for (const Damage& damage : damages()) {
    Glb glb = good;
    damage.change(glb);
    const auto mesh = decode_mesh(put_together(glb), "damaged.glb");
    EXPECT_EQ(code_of(mesh), damage.code) << damage.what << ": " << detail_of(mesh);
    EXPECT_THAT(detail_of(mesh), HasSubstr(damage.detail)) << damage.what;
  }
}

TEST(GltfHostile, every_truncation_of_a_glb_and_of_a_gltf_is_refused) {
  for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf}) {
    const std::vector<std::byte> bytes = encode_mesh(tetrahedron(), format).value();
    for (std::size_t size = 1; size < bytes.size(); ++size) {
      const auto mesh = decode_mesh(std::span(bytes).first(size), "cut");
      EXPECT_THAT(code_of(mesh), AnyOf("truncated_input", "malformed_input", "unknown_format")) << size;
    }
  }
}

TEST(GltfHostile, every_flipped_bit_is_survived) {
  for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf}) {
    std::vector<std::byte> bytes = encode_mesh(tetrahedron(), format).value();
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      const auto mesh = decode_mesh(bytes, "flipped");
      if (mesh) {
        for (const Triangle& t : mesh->triangles) EXPECT_LT(*std::ranges::max_element(t), mesh->positions.size());
      }
      EXPECT_NE(code_of(mesh), "internal_error") << bit << ": " << detail_of(mesh);
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    }
  }
}

TEST(GltfHostile, a_million_bytes_of_anything_take_less_than_two_seconds_and_200_megabytes) {
  if (measuring_is_moot()) GTEST_SKIP() << "sanitizers change time and memory";
  const std::string start = R"({"asset":{"version":"2.0"},"extras":)";
  std::string objects;
  while (objects.size() < 1000000) objects += R"({"":)";
  std::string empties = "[";
  while (empties.size() < 1000000) empties += "[],";
  // Nodes that all show the same mesh, and primitives that all share one accessor.
  Glb instances = glb_of(torus_mesh(60, 50));
  for (int i = 1; i < 50000; ++i) {
    instances.json["nodes"].push_back(Json{{"mesh", 0}});
    instances.json["scenes"][0]["nodes"].push_back(i);
  }
  Glb shared = glb_of(torus_mesh(60, 50));
  for (int i = 0; i < 15000; ++i)
    shared.json["meshes"][0]["primitives"].push_back(shared.json["meshes"][0]["primitives"][0]);
  const std::vector<std::vector<std::byte>> files{
      bytes_of(start + std::string(1000000, '[')),
      bytes_of(start + std::string(500000, '[') + std::string(500000, ']') + "}"),
      bytes_of(start + objects),
      bytes_of(start + empties + "1]}"),
      put_together(instances),
      put_together(shared)};
  for (const std::vector<std::byte>& bytes : files) {
    const ChildRun run = run_in_child([&] { return decode_mesh(bytes, "big").ok() ? 1 : 0; });
    EXPECT_EQ(run.result, 0) << bytes.size();
    EXPECT_LT(run.seconds, 2) << bytes.size();
    EXPECT_LT(run.peak_bytes, std::uint64_t{200} << 20) << bytes.size();
  }
}

}  // namespace
}  // namespace surfaced
