// SPDX-License-Identifier: GPL-3.0-or-later
// glTF packed by KHR_draco_mesh_compression and EXT_meshopt_compression: written, read again, damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "io/io.hpp"
#include "support/glb_files.hpp"
#include "support/limited_child.hpp"
#include "support/results.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr std::string_view kMeshopt = "EXT_meshopt_compression";

TriangleMesh painted_torus(std::size_t around, std::size_t along) {
  TriangleMesh mesh = torus_mesh(around, along);
  for (Point3& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
    mesh.normals.push_back(p[2] > 0 ? Normal3{0, 0.6F, 0.8F} : Normal3{1, 0, 0});
    mesh.colors.push_back({static_cast<std::uint8_t>(mesh.normals.size()), 7, 9, 255});
  }
  return mesh;
}

std::vector<VertexScalar> two_scalars(const TriangleMesh& mesh) {
  VertexScalar first{"_L_OVER_R", {}};
  VertexScalar second{"_R_OVER_L", {}};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    first.values.push_back(static_cast<float>(v) / 7);
    second.values.push_back(1 / (1 + static_cast<float>(v)));
  }
  return {first, second};
}

EncodeOptions packed_by(MeshCompression compression, std::optional<int> bits = {}) {
  EncodeOptions options;
  options.compression = compression;
  options.quantization_bits = bits;
  return options;
}

TriangleMesh sorted(TriangleMesh mesh) {
  sort_triangles(mesh);
  return mesh;
}

TEST(GltfPacking, loses_nothing_without_quantisation) {
  for (const TriangleMesh& mesh : {tetrahedron(), painted_torus(40, 30), painted_torus(300, 230)}) {
    for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
      for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf}) {
        EncodeOptions options = packed_by(compression);
        options.scalars = two_scalars(mesh);
        const auto bytes = encode_mesh(mesh, format, options);
        ASSERT_TRUE(bytes) << detail_of(bytes);
        EXPECT_EQ(*bytes, encode_mesh(mesh, format, options).value()) << "the same bytes again";
        const auto back = decode_mesh(*bytes, "packed");
        ASSERT_TRUE(back) << detail_of(back);
        EXPECT_EQ(back->positions, mesh.positions);
        EXPECT_EQ(back->normals, mesh.normals);
        EXPECT_EQ(back->colors, mesh.colors);
        EXPECT_EQ(sorted(*back).triangles, sorted(mesh).triangles);
      }
    }
  }
}

TEST(GltfPacking, makes_files_smaller) {
  const TriangleMesh mesh = painted_torus(200, 150);
  const std::size_t plain = encode_mesh(mesh, MeshFormat::glb).value().size();
  for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
    const std::size_t exact = encode_mesh(mesh, MeshFormat::glb, packed_by(compression)).value().size();
    const std::size_t coarse = encode_mesh(mesh, MeshFormat::glb, packed_by(compression, 12)).value().size();
    EXPECT_LT(exact, 0.7 * static_cast<double>(plain));
    EXPECT_LT(coarse, exact);
  }
}

TEST(GltfPacking, quantised_positions_err_by_their_bits_and_lie_within_the_bounds_that_the_file_gives) {
  const TriangleMesh mesh = painted_torus(40, 30);
  for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
    for (const int bits : {8, 12, 16, 24, 30}) {
      const auto bytes = encode_mesh(mesh, MeshFormat::glb, packed_by(compression, bits)).value();
      const auto back = decode_mesh(bytes, "packed");
      ASSERT_TRUE(back) << detail_of(back);
      const Json accessor = take_apart(bytes).json["accessors"][0];
      double worst = 0;
      for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        worst = std::max(worst, norm(back->positions[v] - mesh.positions[v]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_GE(back->positions[v][axis], accessor["min"][axis].get<double>());
          EXPECT_LE(back->positions[v][axis], accessor["max"][axis].get<double>());
        }
      }
      EXPECT_LE(worst, 4 * std::ldexp(1.0, -std::min(bits, 22))) << bits;
    }
  }
}

TEST(GltfPacking, more_bits_than_a_float32_has_keep_its_positions_exactly_and_cost_no_more) {
  const TriangleMesh mesh = painted_torus(40, 30);
  for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
    const auto exact =
        decode_mesh(encode_mesh(mesh, MeshFormat::glb, packed_by(compression, std::nullopt)).value(), "exact");
    for (const int bits : {25, 30}) {
      const auto bytes = encode_mesh(mesh, MeshFormat::glb, packed_by(compression, bits)).value();
      const auto back = decode_mesh(bytes, "packed");
      ASSERT_TRUE(back) << detail_of(back);
      EXPECT_EQ(back->positions, exact->positions) << bits;
    }
  }
}

TEST(GltfPacking, scalars_stand_in_a_plain_file_as_attributes_and_in_a_ply_as_properties) {
  const TriangleMesh mesh = painted_torus(12, 8);
  EncodeOptions options;
  options.scalars = two_scalars(mesh);
  const Glb glb = take_apart(encode_mesh(mesh, MeshFormat::glb, options).value());
  const Json& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
  const Json& accessor = glb.json["accessors"][attributes["_R_OVER_L"].get<std::size_t>()];
  EXPECT_EQ(accessor["type"], "SCALAR");
  EXPECT_EQ(accessor["count"], 96);
  const std::size_t view = accessor["bufferView"];
  float second = 0;
  std::memcpy(&second, glb.binary.data() + glb.json["bufferViews"][view]["byteOffset"].get<std::size_t>() + 4, 4);
  EXPECT_EQ(second, 0.5F);
  const auto ply = encode_mesh(mesh, MeshFormat::ply, options).value();
  const std::string header(reinterpret_cast<const char*>(ply.data()), 400);
  EXPECT_THAT(header, HasSubstr("property float l_over_r\nproperty float r_over_l\n"));
  const auto back = decode_mesh(ply, "mesh.ply");
  ASSERT_TRUE(back) << detail_of(back);
  EXPECT_EQ(back->positions, mesh.positions);
  options.scalars[0].values.pop_back();
  EXPECT_THAT(detail_of(encode_mesh(mesh, MeshFormat::glb, options)), HasSubstr("95 values for 96"));
}

/// A small meshopt GLB, taken apart.
Glb small_packed() {
  return take_apart(encode_mesh(tetrahedron(), MeshFormat::glb, packed_by(MeshCompression::meshopt)).value());
}

Json& extension_of(Glb& glb, std::size_t view) { return glb.json["bufferViews"][view]["extensions"][kMeshopt]; }

TEST(GltfPackingHostile, lies_in_the_extension_are_refused) {
  struct Lie {
    const char* key;
    Json value;
    const char* code;
    const char* detail;
  };
  const std::vector<Lie> lies{
      {"count", 4'000'000'000'000, "unsupported_feature", "bytes are left"},
      {"count", 3, "malformed_input", "room for 3"},
      {"count", 400, "malformed_input", "damaged"},
      {"count", -1, "malformed_input", "count"},
      {"byteStride", 0, "malformed_input", "go together"},
      {"byteStride", 13, "malformed_input", "go together"},
      {"byteStride", 260, "unsupported_feature", "260 bytes"},
      {"mode", "TRIANGLES", "malformed_input", "go together"},
      {"mode", "HEAPS", "malformed_input", "HEAPS"},
      {"filter", "OCTAHEDRAL", "malformed_input", "go together"},
      {"filter", 7, "malformed_input", "filter"},
      {"byteLength", 1'000'000, "malformed_input", "1000000"},
      {"buffer", 9, "malformed_input", "buffer 9"},
      {"buffer", 1, "malformed_input", "of a buffer of 0"},
  };
  for (const Lie& lie : lies) {
    Glb glb = small_packed();
    extension_of(glb, 0)[lie.key] = lie.value;
    const auto mesh = decode_mesh(put_together(glb), "lie.glb");
    EXPECT_EQ(code_of(mesh), lie.code) << lie.key << " " << lie.value << ": " << detail_of(mesh);
    EXPECT_THAT(detail_of(mesh), HasSubstr(lie.detail)) << lie.key;
  }
}

TEST(GltfPackingHostile, every_truncation_and_flipped_bit_is_survived) {
  for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
    const Glb glb = take_apart(encode_mesh(tetrahedron(), MeshFormat::glb, packed_by(compression)).value());
    for (std::size_t bit = 0; bit < 8 * glb.binary.size(); ++bit) {
      Glb flipped = glb;
      flipped.binary[bit / 8] = static_cast<char>(flipped.binary[bit / 8] ^ 1 << bit % 8);
      EXPECT_NE(code_of(decode_mesh(put_together(flipped), "flipped.glb")), "internal_error") << bit;
    }
    for (std::size_t size = 0; size + 1 < glb.binary.size(); ++size) {
      Glb cut = glb;
      cut.binary.resize(size);
      EXPECT_THAT(code_of(decode_mesh(put_together(cut), "cut.glb")),
                  AnyOf("truncated_input", "malformed_input", "empty_input"))
          << size;
    }
  }
}

TEST(GltfPackingHostile, a_small_file_that_unpacks_to_gigabytes_is_refused_in_little_time_and_memory) {
  if (measuring_is_moot()) GTEST_SKIP() << "sanitizers change time and memory";
  Glb glb = small_packed();
  // Each view declares what the limit for one of them allows; together they may not.
  const Json view = glb.json["bufferViews"][0];
  for (int i = 0; i < 1000; ++i) glb.json["bufferViews"].push_back(view);
  for (Json& each : glb.json["bufferViews"]) {
    each["extensions"][kMeshopt]["count"] = 60'000'000 / 12;
    each["extensions"][kMeshopt]["byteStride"] = 12;
    each["extensions"][kMeshopt]["mode"] = "ATTRIBUTES";
  }
  const std::vector<std::byte> bytes = put_together(glb);
  const ChildRun run = run_in_child([&] { return decode_mesh(bytes, "bomb.glb").ok() ? 1 : 0; });
  EXPECT_EQ(run.result, 0);
  EXPECT_LT(run.seconds, 2);
  EXPECT_LT(run.peak_bytes, std::uint64_t{200} << 20);
}

}  // namespace
}  // namespace surfaced
