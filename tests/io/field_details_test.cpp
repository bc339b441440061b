// SPDX-License-Identifier: GPL-3.0-or-later
// Details of formats as programs write them, beyond what their specifications have in mind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/io.hpp"
#include "support/results.hpp"
#include "support/scan_files.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Points = std::vector<Point3>;
using Colors = std::vector<Color4>;

std::string ply_of(const std::string& format, const std::string& properties, const std::string& rows, int count = 1) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(count) +
         "\nproperty float x\nproperty float y\nproperty float z\n" + properties + "end_header\n" + rows;
}

TEST(PlyDetails, a_byte_order_mark_and_blanks_behind_ply_are_no_matter) {
  const std::string text = ply_of("ascii", "", "1 2 3\n");
  EXPECT_EQ(read("\xef\xbb\xbf" + text).positions, (Points{{1, 2, 3}}));
  EXPECT_EQ(read("ply \t\r\n" + text.substr(4)).positions, (Points{{1, 2, 3}}));
}

TEST(PlyDetails, names_may_be_written_large) {
  EXPECT_EQ(read("ply\nformat ascii 1.0\nelement vertex 1\nproperty float X\nproperty float Y\nproperty float Z\n"
                 "property uchar Red\nproperty uchar Green\nproperty uchar Blue\nend_header\n1 2 3 4 5 6\n")
                .colors,
            (Colors{{4, 5, 6, 255}}));
}

TEST(PlyDetails, packed_colours_are_read_from_integers_and_from_floats) {
  for (const std::string order : {"binary_little_endian", "binary_big_endian"}) {
    for (const std::string type : {"float", "uint", "int"}) {
      std::string rows(16, '\0');
      for (std::size_t i = 0; i < 4; ++i) {
        const std::string bytes("\x03\x02\x01\x80", 4);
        rows[12 + i] = order == "binary_big_endian" ? bytes[3 - i] : bytes[i];
      }
      EXPECT_EQ(read(ply_of(order, "property " + type + " rgb\n", rows)).colors, (Colors{{1, 2, 3, 255}}));
      EXPECT_EQ(read(ply_of(order, "property " + type + " rgba\n", rows)).colors, (Colors{{1, 2, 3, 128}}));
    }
  }
  EXPECT_EQ(read(ply_of("ascii", "property uint rgb\n", "1 2 3 66051\n")).colors, (Colors{{1, 2, 3, 255}}));
}

const std::string kGaussian =
    "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float opacity\nproperty float "
    "scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\n";

TEST(PlyDetails, gaussians_have_the_colour_of_their_first_harmonic_and_are_filtered_if_that_is_wanted) {
  // Opacity 1/2 and 0.12, longest half-axes 1 and e.
  const std::string text = ply_of("ascii", kGaussian, "1 2 3 0 10 -10 0 -1 0 -1 1\n4 5 6 0 0 0 -2 1 0 0 1\n", 2);
  const RawCloud all = read(text);
  EXPECT_EQ(all.colors, (Colors{{128, 255, 0, 255}, {128, 128, 128, 255}}));
  EXPECT_THAT(all.warnings, ElementsAre(HasSubstr("splat_opacity")));
  ReadOptions options;
  options.splats.least_opacity = 0.3;
  EXPECT_EQ(read(text, options).positions, (Points{{1, 2, 3}}));
  options.splats = {.least_opacity = {}, .largest_scale = 1.5};
  EXPECT_EQ(read(text, options).positions, (Points{{1, 2, 3}}));
  EXPECT_EQ(read(text, options).colors.size(), 1U);
}

TEST(PlyDetails, faces_of_a_mesh_that_is_sent_as_a_cloud_are_counted_and_said) {
  for (const MeshFormat format :
       {MeshFormat::ply, MeshFormat::glb, MeshFormat::obj, MeshFormat::stl, MeshFormat::drc, MeshFormat::threemf}) {
    const auto bytes = encode_mesh(tetrahedron(), format).value();
    const auto cloud = parse_cloud(bytes, "tetrahedron");
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    EXPECT_EQ(cloud->source.faces, 4U) << name_of(format);
    EXPECT_THAT(cloud->warnings.back(), HasSubstr("input=mesh")) << name_of(format);
  }
}

TEST(PcdDetails, fields_that_take_no_place_are_skipped) {
  const std::string head =
      "VERSION .7\nFIELDS x y _ z _\nSIZE 4 4 1 4 2\nTYPE F F U F U\nCOUNT 1 1 0 1 3\nWIDTH 1\nHEIGHT 1\n";
  EXPECT_EQ(read(head + "DATA ascii\n1 2 3 9 9 9\n").positions, (Points{{1, 2, 3}}));
  ByteWriter w;
  w.put(1.F).put(2.F).put(3.F).zeros(6);
  EXPECT_EQ(read(head + "DATA binary\n" + w.text).positions, (Points{{1, 2, 3}}));
}

TEST(PcdDetails, colours_in_three_fields_of_any_type_are_read) {
  for (const char* names : {"red green blue", "r g b"}) {
    const std::string head = "VERSION .7\nFIELDS x y z " + std::string(names) +
                             "\nSIZE 8 8 8 8 8 8\nTYPE F F F F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n";
    EXPECT_EQ(read(head + "1 2 3 255 0 7\n4 5 6 1 2 3\n").colors, (Colors{{255, 0, 7, 255}, {1, 2, 3, 255}}));
  }
}

TEST(StlDetails, bytes_behind_the_last_facet_are_ignored_with_a_warning_and_missing_ones_are_an_error) {
  const std::string text = binary_stl(two_facets(), "made by hand");
  const RawCloud cloud = read(text + "more");
  EXPECT_EQ(cloud.positions, read(text).positions);
  EXPECT_THAT(cloud.warnings.front(), HasSubstr("4 bytes after the last facet ignored"));
  EXPECT_EQ(code_of(parse_text(text.substr(0, text.size() - 1))), "truncated_input");
}

TEST(StlDetails, lines_behind_the_last_solid_are_left_with_a_warning_and_another_solid_is_read) {
  const std::string solid = ascii_stl(two_facets());
  EXPECT_THAT(read(solid + "\n# made by a program\n\x1a\n").warnings,
              ::testing::Contains("2 lines after the last 'endsolid' ignored"));
  const RawCloud two = read(solid + solid + "exported in 2024\n");
  EXPECT_EQ(two.size(), 2 * read(solid).size());
  EXPECT_THAT(two.warnings, ::testing::Contains("1 lines after the last 'endsolid' ignored"));
}

TEST(ObjDetails, a_statement_goes_on_behind_a_backslash) {
  EXPECT_EQ(read("g \\\nname\nv 1 \\\n 2 \\\r\n 3\nv 4 5 6\n").positions, (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(read("v 1 2 3\nv 4 5 6 \\").positions.size(), 2U);
}

TEST(LasDetails, a_count_that_is_too_small_is_warned_of_and_one_too_large_is_taken_if_that_is_wanted) {
  const std::vector<LasPoint> points{{{1, 1, 1}, {}}, {{2, 2, 2}, {}}, {{3, 3, 3}, {}}};
  const RawCloud few = read(las_file(points, {.declared = 2}));
  EXPECT_EQ(few.size(), 2U);
  EXPECT_THAT(few.warnings, ElementsAre(HasSubstr("declares 2 points, 3 are there")));
  EXPECT_THAT(read(las_file(points)).warnings, IsEmpty());
  const std::string many = las_file(points, {.declared = 9});
  EXPECT_THAT(detail_of(parse_text(many)), HasSubstr("truncated=take"));
  ReadOptions options;
  options.take_truncated = true;
  EXPECT_EQ(read(many, options).size(), 3U);
  EXPECT_THAT(read(many, options).warnings, ElementsAre(HasSubstr("declares 9 points, 3 are there")));
}

TEST(LasDetails, what_is_said_to_lie_before_the_points_does_not_end_them) {
  const std::vector<LasPoint> points{{{1, 1, 1}, {}}, {{2, 2, 2}, {}}};
  EXPECT_EQ(read(las_file(points, {.minor = 3, .waveforms = 60})).size(), 2U);
}

/// Four points of 16 bits, and normals of 8, in a node that scales and moves them.
std::string quantised_gltf(bool normalized) {
  const std::string flag = normalized ? R"("normalized":true,)" : "";
  return R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"mesh":0,"scale":[2,2,2],"translation":[1,0,0]}],"meshes":[{"primitives":[{"mode":0,)"
         R"("attributes":{"POSITION":0,"NORMAL":1}}]}],"accessors":[{"bufferView":0,)" +
         flag +
         R"("componentType":5122,"count":2,"type":"VEC3"},{"bufferView":1,"normalized":true,"componentType":5120,)"
         R"("count":2,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":16,"byteStride":8},{"buffer":0,)"
         R"("byteOffset":16,"byteLength":8,"byteStride":4}],"buffers":[{"byteLength":24,"uri":)"
         R"("data:application/octet-stream;base64,AQD+/wAAAAABgP9/AAAAAAAAfwB/AAAA"}]})";
}

TEST(GltfDetails, positions_of_16_bits_and_normals_of_8_are_read) {
  const RawCloud plain = read(quantised_gltf(false));
  EXPECT_EQ(plain.positions, (Points{{3, -4, 0}, {1 - 2.0 * 32767, 2.0 * 32767, 0}}));
  EXPECT_EQ(plain.normals, (std::vector<Normal3>{{0, 0, 1}, {1, 0, 0}}));
  const RawCloud unit = read(quantised_gltf(true));
  EXPECT_EQ(unit.positions[1], (Point3{-1, 2, 0}));
}

TEST(GltfDetails, normalized_says_nothing_of_floats) {
  const RawCloud cloud = read(
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"mode":0,)"
      R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"normalized":true,"componentType":5126,)"
      R"("count":1,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[{"byteLength":12,"uri":)"
      R"("data:application/octet-stream;base64,AACgwAAA4MAAAAAA"}]})");
  EXPECT_EQ(cloud.positions, (Points{{-5, -7, 0}}));
}

}  // namespace
}  // namespace surfaced
