// SPDX-License-Identifier: GPL-3.0-or-later
// What a file does to the surface, for readers that join vertices by position.
#include "reconstruction/encoding.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "quality/quality.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

EncodingEffect effect(const TriangleMesh& mesh, MeshFormat format, std::optional<int> bits) {
  EncodeOptions options;
  options.quantization_bits = bits;
  Context context;
  const auto bytes = encode_mesh(mesh, format, options);
  const auto result = effect_of_encoding(mesh, decode_mesh(*bytes, "test").value(), format, options, context);
  EXPECT_TRUE(result.ok());
  return *result;
}

/// Two tori, one above the other, so near that coarse coordinates join them.
TriangleMesh stacked_tori(double gap) {
  const TriangleMesh torus = testing::torus_mesh(40, 20);
  const Bounds bounds = bounds_of(torus.positions);
  return testing::together(torus, torus, {0, 0, bounds.high[2] - bounds.low[2] + gap});
}

/// Edges by position with other than two triangles.
std::size_t odd_edges(const TriangleMesh& mesh) {
  std::map<std::pair<Point3, Point3>, int> uses;
  for (const Triangle& t : mesh.triangles) {
    const std::set<Point3> corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    if (corners.size() < 3) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      ++uses[std::minmax(mesh.positions[t.at(i)], mesh.positions[t.at((i + 1) % 3)])];
    }
  }
  std::size_t odd = 0;
  for (const auto& [edge, count] : uses) odd += count == 2 ? 0U : 1U;
  return odd;
}

TEST(Encoding, tells_what_readers_see_that_join_vertices_by_position) {
  const TriangleMesh tori = stacked_tori(1e-4);
  ASSERT_TRUE(topology_of(tori).closed);
  const EncodingEffect coarse = effect(tori, MeshFormat::drc, 8);
  ASSERT_TRUE(coarse.by_position);
  EXPECT_EQ(coarse.by_position->components, 1U);
  EXPECT_GT(coarse.by_position->non_manifold_edges, 0U);
  EXPECT_THAT(encoding_warnings(coarse), Contains(HasSubstr("readers that join vertices by position")));
  EXPECT_EQ(effect(tori, MeshFormat::drc, 20).by_position, std::nullopt);
}

TEST(Encoding, names_the_least_bits_that_change_nothing) {
  const TriangleMesh tori = stacked_tori(1e-4);
  const EncodingEffect coarse = effect(tori, MeshFormat::drc, 8);
  ASSERT_TRUE(coarse.least_bits);
  for (int bits = 8; bits <= *coarse.least_bits; ++bits) {
    EncodeOptions options;
    options.quantization_bits = bits;
    const TriangleMesh decoded = decode_mesh(*encode_mesh(tori, MeshFormat::drc, options), "test").value();
    const bool unchanged = odd_edges(decoded) == 0 && count_self_intersections(decoded) == 0;
    EXPECT_EQ(unchanged, bits == *coarse.least_bits) << bits;
  }
  EXPECT_THAT(encoding_warnings(coarse),
              Contains(HasSubstr("quantization=" + std::to_string(*coarse.least_bits) + " changes nothing")));
}

TEST(Encoding, counts_the_crossings_that_bits_make_and_not_those_that_were_there) {
  const TriangleMesh torus = testing::torus_mesh(40, 20);
  const TriangleMesh crossing = testing::together(torus, torus, {0.0123, 0.0457, 0.5012});
  ASSERT_GT(count_self_intersections(crossing), 0U);
  const EncodingEffect fine = effect(crossing, MeshFormat::drc, 24);
  EXPECT_EQ(fine.crossings_made, 0U);
  EXPECT_THAT(encoding_warnings(fine), IsEmpty());
  EXPECT_EQ(effect(crossing, MeshFormat::glb, std::nullopt).crossings_made, std::nullopt);
  // A sheet over another, at a height that half of the coarse coordinates round down to it.
  TriangleMesh sheets;
  constexpr std::size_t kSide = 20;
  for (std::size_t sheet = 0; sheet < 2; ++sheet) {
    for (std::size_t i = 0; i < kSide; ++i) {
      for (std::size_t j = 0; j < kSide; ++j) {
        const double half = sheet == 0 ? 0 : 0.05;
        const double height = sheet == 0 ? 0 : (i * 7 + j * 11) % 2 == 0 ? 0.0030 : 0.0045;
        sheets.positions.push_back({0.1 * static_cast<double>(i) + half, 0.1 * static_cast<double>(j) + half, height});
        if (i + 1 == kSide || j + 1 == kSide) continue;
        const std::size_t at = (sheet * kSide + i) * kSide + j;
        sheets.triangles.push_back(testing::triangle(at, at + kSide, at + kSide + 1));
        sheets.triangles.push_back(testing::triangle(at, at + kSide + 1, at + 1));
      }
    }
  }
  ASSERT_EQ(count_self_intersections(sheets), 0U);
  const EncodingEffect coarse = effect(sheets, MeshFormat::drc, 8);
  EXPECT_GT(coarse.crossings_made.value_or(0), 0U);
  EXPECT_THAT(encoding_warnings(coarse), Contains(HasSubstr("pairs of triangles cross")));
}

}  // namespace
}  // namespace surfaced
