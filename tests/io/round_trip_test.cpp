// SPDX-License-Identifier: GPL-3.0-or-later
// What is written is read again, bit for bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "io/io.hpp"
#include "support/limited_child.hpp"
#include "support/results.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::HasSubstr;

constexpr std::array kFormats{MeshFormat::glb, MeshFormat::gltf, MeshFormat::drc, MeshFormat::ply};

/// Equal as bytes: -0 is not 0.
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TriangleMesh as_floats(TriangleMesh mesh) {
  for (Point3& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  return mesh;
}

TriangleMesh with_normals(TriangleMesh mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.normals.push_back(i % 2 == 0 ? Normal3{0, 0.6F, 0.8F} : Normal3{1, 0, 0});
  }
  return mesh;
}

TriangleMesh with_colors(TriangleMesh mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.colors.push_back(
        {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 3), 200, static_cast<std::uint8_t>(255 - i % 2)});
  }
  return mesh;
}

/// Coordinates at the ends of float32, and triangles in no order that an encoder would choose.
TriangleMesh extreme_mesh() {
  TriangleMesh mesh;
  const double max = std::numeric_limits<float>::max();
  const double least = std::numeric_limits<float>::denorm_min();
  mesh.positions = {
      {max, -max, least}, {-0.0, 0.0, -least}, {static_cast<double>(0.1F), 1, -1}, {5, 6, 7}, {max, max, max}};
  mesh.triangles = {triangle(4, 3, 0), triangle(0, 1, 4), triangle(2, 1, 0)};
  return mesh;
}

std::vector<TriangleMesh> exact_meshes() {
  std::vector<TriangleMesh> meshes{tetrahedron(), as_floats(torus_mesh(40, 30)), extreme_mesh()};
  meshes.push_back(with_normals(meshes[1]));
  meshes.push_back(with_colors(meshes[1]));
  meshes.push_back(with_colors(with_normals(meshes[1])));
  meshes.push_back(as_floats(torus_mesh(300, 250)));  // more vertices than 16-bit indices reach
  std::mt19937 random(3);
  std::ranges::shuffle(meshes[4].triangles, random);
  return meshes;
}

TEST(RoundTrip, meshes_that_float32_holds_come_back_bit_for_bit_in_every_format) {
  for (const TriangleMesh& mesh : exact_meshes()) {
    for (const MeshFormat format : kFormats) {
      for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
        const auto bytes = encode_mesh(mesh, format, {.quantization_bits = {}, .up = up, .extras_json = {}});
        ASSERT_TRUE(bytes.ok()) << detail_of(bytes);
        std::vector<std::string> warnings;
        const auto back = decode_mesh(*bytes, "mesh", &warnings);
        ASSERT_TRUE(back.ok()) << detail_of(back);
        EXPECT_TRUE(same_bits(back->positions, mesh.positions)) << static_cast<int>(format);
        EXPECT_TRUE(same_bits(back->normals, mesh.normals)) << static_cast<int>(format);
        EXPECT_EQ(back->colors, mesh.colors);
        EXPECT_EQ(back->triangles, mesh.triangles);
        EXPECT_TRUE(warnings.empty());
      }
    }
  }
}

TEST(RoundTrip, obj_and_3mf_keep_vertices_and_triangles_bit_for_bit) {
  for (const TriangleMesh& mesh : exact_meshes()) {
    const auto obj = decode_mesh(encode_mesh(mesh, MeshFormat::obj).value(), "mesh.obj");
    ASSERT_TRUE(obj.ok()) << detail_of(obj);
    EXPECT_TRUE(same_bits(obj->positions, mesh.positions));
    EXPECT_TRUE(same_bits(obj->normals, mesh.normals));
    EXPECT_EQ(obj->triangles, mesh.triangles);
    ASSERT_EQ(obj->colors.size(), mesh.colors.size());
    for (std::size_t v = 0; v < mesh.colors.size(); ++v) {
      EXPECT_TRUE(std::ranges::equal(std::span(obj->colors[v]).first(3), std::span(mesh.colors[v]).first(3)));
    }
    const auto printed = decode_mesh(encode_mesh(mesh, MeshFormat::threemf).value(), "mesh.3mf");
    ASSERT_TRUE(printed.ok()) << detail_of(printed);
    EXPECT_TRUE(same_bits(printed->positions, mesh.positions));
    EXPECT_EQ(printed->triangles, mesh.triangles);
  }
}

TEST(RoundTrip, stl_keeps_every_corner_bit_for_bit) {
  for (const TriangleMesh& mesh : exact_meshes()) {
    const auto stl = decode_mesh(encode_mesh(mesh, MeshFormat::stl).value(), "mesh.stl");
    ASSERT_TRUE(stl.ok()) << detail_of(stl);
    ASSERT_EQ(stl->triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(stl->positions[stl->triangles[t][k]], mesh.positions[mesh.triangles[t][k]]);
      }
    }
  }
}

TEST(RoundTrip, the_same_mesh_gives_the_same_bytes) {
  const TriangleMesh mesh = with_colors(with_normals(torus_mesh(20, 10)));
  for (const MeshFormat format : kFormats) {
    EXPECT_EQ(encode_mesh(mesh, format).value(), encode_mesh(mesh, format).value());
  }
  EXPECT_EQ(encode_mesh(mesh, MeshFormat::threemf).value(), encode_mesh(mesh, MeshFormat::threemf).value());
}

TriangleMesh far_away() {
  TriangleMesh mesh = torus_mesh(20, 15);
  for (Point3& p : mesh.positions) p = {p[0] * 50 + 412345.678, p[1] * 50 + 5654321.123, p[2] * 50 + 123.456};
  return mesh;
}

TEST(RoundTrip, doubles_are_exact_in_ply_and_draco) {
  for (const MeshFormat format : {MeshFormat::ply, MeshFormat::drc, MeshFormat::obj}) {
    const TriangleMesh mesh = far_away();
    const auto back = decode_mesh(encode_mesh(mesh, format).value(), "mesh");
    ASSERT_TRUE(back.ok()) << detail_of(back);
    EXPECT_TRUE(same_bits(back->positions, mesh.positions));
  }
}

TEST(RoundTrip, doubles_far_away_lose_less_than_half_a_float32_step_of_the_meshs_size_in_gltf) {
  const TriangleMesh mesh = far_away();
  const double step = std::ldexp(1.0, -24 + 6);  // coordinates relative to the origin stay below 2^7
  for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf}) {
    for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
      const auto bytes = encode_mesh(mesh, format, {.quantization_bits = {}, .up = up, .extras_json = {}});
      const auto back = decode_mesh(bytes.value(), "mesh");
      ASSERT_TRUE(back.ok()) << detail_of(back);
      for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_NEAR(back->positions[i][axis], mesh.positions[i][axis], step);
        }
      }
    }
  }
}

TEST(RoundTrip, doubles_far_away_keep_their_origin_in_stl_and_3mf) {
  const TriangleMesh mesh = far_away();
  for (const MeshFormat format : {MeshFormat::stl, MeshFormat::threemf}) {
    const auto back = decode_mesh(encode_mesh(mesh, format).value(), "mesh");
    ASSERT_TRUE(back.ok()) << detail_of(back);
    ASSERT_EQ(back->triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_LT(norm(back->positions[back->triangles[t][k]] - mesh.positions[mesh.triangles[t][k]]), 1e-5);
      }
    }
  }
}

TEST(RoundTrip, doubles_at_the_ends_of_float32_stay_finite_in_gltf) {
  TriangleMesh mesh = tetrahedron();
  for (Point3& p : mesh.positions) {
    for (double& x : p) x *= 3.4e38;
  }
  mesh.positions[0][0] = 0.1;
  const auto back = decode_mesh(encode_mesh(mesh, MeshFormat::glb).value(), "mesh");
  ASSERT_TRUE(back.ok()) << detail_of(back);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(back->positions[i][axis], static_cast<double>(static_cast<float>(mesh.positions[i][axis])));
    }
  }
}

TEST(RoundTrip, quantised_draco_errs_by_no_more_than_half_a_step) {
  const TriangleMesh mesh = as_floats(torus_mesh(40, 30));
  std::size_t before = encode_mesh(mesh, MeshFormat::drc).value().size();
  for (const int bits : {16, 12, 8}) {
    const auto bytes =
        encode_mesh(mesh, MeshFormat::drc, {.quantization_bits = bits, .up = UpAxis::y, .extras_json = {}});
    ASSERT_TRUE(bytes.ok()) << detail_of(bytes);
    EXPECT_LE(bytes->size(), before);
    before = bytes->size();
    const auto back = decode_mesh(*bytes, "mesh");
    ASSERT_TRUE(back.ok()) << detail_of(back);
    EXPECT_EQ(back->triangles, mesh.triangles);
    const double half_step = 2.6 / (std::ldexp(1.0, bits) - 1) / 2 * 1.001;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(back->positions[i][axis], mesh.positions[i][axis], half_step);
      }
    }
  }
}

TEST(RoundTrip, positions_near_the_largest_float_are_kept_instead_of_quantised) {
  TriangleMesh mesh = tetrahedron();
  mesh.positions = {{-1e38, 0, 0}, {1.6e38, 1, 0}, {0, 3e38, 1}, {1, 1e38, -3e38}};
  for (const int bits : {11, 21}) {
    const auto bytes =
        encode_mesh(mesh, MeshFormat::drc, {.quantization_bits = bits, .up = UpAxis::y, .extras_json = {}}).value();
    const auto back = decode_mesh(bytes, "mesh");
    ASSERT_TRUE(back) << detail_of(back);
    EXPECT_EQ(back->positions, mesh.positions);
  }
}

TEST(RoundTrip, few_values_of_many_bits_take_no_more_memory_than_others) {
  const TriangleMesh mesh = as_floats(torus_mesh(40, 30));
  for (const int bits : {22, 23, 26, 30}) {
    std::vector<std::byte> bytes;
    const auto write = [&] {
      bytes =
          encode_mesh(mesh, MeshFormat::drc, {.quantization_bits = bits, .up = UpAxis::y, .extras_json = {}}).value();
      return 0;
    };
    if (!measuring_is_moot()) {
      const ChildRun run = run_in_child(write);
      EXPECT_EQ(run.result, 0) << bits;
      EXPECT_LT(run.seconds, 1) << bits;
      EXPECT_LT(run.peak_bytes, std::uint64_t{200} << 20) << bits;
    }
    write();
    const auto back = decode_mesh(bytes, "mesh");
    ASSERT_TRUE(back.ok()) << detail_of(back);
    EXPECT_EQ(back->triangles, mesh.triangles);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(back->positions[i][axis], mesh.positions[i][axis], 2.6 * 0x1p-22) << bits;
      }
    }
  }
}

TEST(RoundTrip, a_quantised_file_that_compresses_better_than_dracos_decoder_believes_is_still_decoded) {
  const TriangleMesh mesh = as_floats(torus_mesh(150, 100));
  const auto bytes = encode_mesh(mesh, MeshFormat::drc, {.quantization_bits = 8, .up = UpAxis::y, .extras_json = {}});
  ASSERT_TRUE(bytes.ok()) << detail_of(bytes);
  EXPECT_EQ(bytes->back(), std::byte{0}) << "filled up";
  const auto back = decode_mesh(*bytes, "mesh");
  ASSERT_TRUE(back.ok()) << detail_of(back);
  EXPECT_EQ(back->triangles, mesh.triangles);
}

TEST(RoundTrip, a_cloud_comes_back_from_ply_as_it_was) {
  for (const bool exact : {true, false}) {
    RawCloud cloud = raw_cloud(exact ? as_floats(torus_mesh(10, 9)).positions : far_away().positions);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.normals.push_back({0.5F, static_cast<float>(i), -1});
      cloud.colors.push_back({1, static_cast<std::uint8_t>(i), 3, 4});
    }
    const std::vector<std::byte> bytes = encode_cloud_ply(cloud.positions, cloud.normals, cloud.colors);
    const auto back = parse_cloud(bytes, "cloud.ply");
    ASSERT_TRUE(back.ok()) << detail_of(back);
    EXPECT_TRUE(same_bits(back->positions, cloud.positions));
    EXPECT_TRUE(same_bits(back->normals, cloud.normals));
    EXPECT_EQ(back->colors, cloud.colors);
  }
}

TEST(RoundTrip, a_draco_mesh_is_read_as_a_cloud_too) {
  const TriangleMesh mesh = with_colors(with_normals(as_floats(torus_mesh(12, 8))));
  const auto cloud = parse_cloud(encode_mesh(mesh, MeshFormat::drc).value(), "mesh.drc");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_TRUE(same_bits(cloud->positions, mesh.positions));
  EXPECT_TRUE(same_bits(cloud->normals, mesh.normals));
  EXPECT_EQ(cloud->colors, mesh.colors);
}

TEST(Encoding, refuses_what_no_file_holds) {
  TriangleMesh mesh = tetrahedron();
  mesh.positions[2][1] = std::numeric_limits<double>::quiet_NaN();
  for (const MeshFormat format : kFormats) {
    EXPECT_EQ(code_of(encode_mesh(mesh, format)), "coordinate_not_finite");
    EXPECT_THAT(detail_of(encode_mesh(mesh, format)), HasSubstr("vertex 2: y"));
  }
  mesh.positions[2][1] = 1e39;
  EXPECT_EQ(code_of(encode_mesh(mesh, MeshFormat::glb)), "coordinate_out_of_range");
  mesh = tetrahedron();
  mesh.triangles[1][2] = VertexIndex(4);
  EXPECT_EQ(code_of(encode_mesh(mesh, MeshFormat::glb)), "internal_error");
  for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf, MeshFormat::drc}) {
    EXPECT_EQ(code_of(encode_mesh({}, format)), "method_failed");
  }
}

TEST(Encoding, refuses_quantisation_out_of_range) {
  for (const int bits : {7, 31, -1}) {
    const auto bytes =
        encode_mesh(tetrahedron(), MeshFormat::drc, {.quantization_bits = bits, .up = UpAxis::y, .extras_json = {}});
    EXPECT_EQ(code_of(bytes), "invalid_parameter");
    EXPECT_THAT(detail_of(bytes), HasSubstr("8 to 30"));
  }
}

TEST(Encoding, refuses_a_draco_mesh_that_its_decoder_would_refuse) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.resize(1);
  EXPECT_EQ(code_of(encode_mesh(mesh, MeshFormat::drc)), "unsupported_feature");
}

}  // namespace
}  // namespace surfaced
