// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds in the formats of other programs, as they are meant to be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

/// The points whose coordinates are numbers, with their attributes.
RawCloud without_unmeasured(RawCloud cloud) {
  for (std::size_t i = cloud.size(); i-- > 0;) {
    if (cloud.positions[i][0] == cloud.positions[i][0]) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    cloud.positions.erase(cloud.positions.begin() + at);
    if (!cloud.normals.empty()) cloud.normals.erase(cloud.normals.begin() + at);
    if (!cloud.colors.empty()) cloud.colors.erase(cloud.colors.begin() + at);
  }
  return cloud;
}

TEST(TextCloud, rows_of_numbers_are_points_whatever_separates_them) {
  for (const char* text : {"1 2 3\n4 5 6.5\n", "1\t2\t3\r\n4\t5\t6.5\r\n", "1,2,3\n4,5,6.5", "1; 2; 3;\n4;5;6,5;\n",
                           "\xef\xbb\xbf 1 2 3\r4 5 6.5", "# c\n\n  +1 2e0 3\n// c\n4 5 0.65e1\n"}) {
    EXPECT_EQ(read(text).positions, (Points{{1, 2, 3}, {4, 5, 6.5}})) << text;
  }
}

TEST(TextCloud, groups_of_three_columns_are_normals_or_colours_by_their_values) {
  const RawCloud colors = read("1 2 3 255 0 7\n4 5 6 0 128 9\n");
  EXPECT_EQ(colors.colors, (Colors{{255, 0, 7, 255}, {0, 128, 9, 255}}));
  EXPECT_TRUE(colors.normals.empty());
  const RawCloud normals = read("1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n");
  EXPECT_EQ(normals.normals, (std::vector<Normal3>{{0, 0, 1}, {0.6F, 0.8F, 0}}));
  EXPECT_TRUE(normals.colors.empty());
  const RawCloud both = read("1 2 3 90 80 70 0 0 1\n4 5 6 60 50 40 -1 0 0\n");
  EXPECT_EQ(both.colors, (Colors{{90, 80, 70, 255}, {60, 50, 40, 255}}));
  EXPECT_EQ(both.normals, (std::vector<Normal3>{{0, 0, 1}, {-1, 0, 0}}));
  EXPECT_THAT(both.warnings, ElementsAre(HasSubstr("guessed from their values")));
  EXPECT_THAT(read("1 2 3\n4 5 6\n").warnings, IsEmpty());
}

TEST(TextCloud, other_columns_are_ignored_with_a_warning) {
  for (const char* text : {"1 2 3 77\n", "1 2 3 4 5\n", "1 2 3 400.5 2 3\n", "class,x,y,z\ntree,1,2,3\n"}) {
    const RawCloud cloud = read(text);
    EXPECT_EQ(cloud.positions, (Points{{1, 2, 3}})) << text;
    EXPECT_TRUE(cloud.normals.empty() && cloud.colors.empty());
    EXPECT_THAT(cloud.warnings, ElementsAre(HasSubstr("ignored"))) << text;
  }
}

TEST(TextCloud, a_header_names_the_columns_in_any_order) {
  const RawCloud cloud = read("Blue,Z,Green,Y,\"X\",red\n0,3,0.5,2,1,1\n1,6,0,5,4,0\n");
  EXPECT_EQ(cloud.positions, (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(cloud.colors, (Colors{{255, 128, 0, 255}, {0, 0, 255, 255}}));
  EXPECT_EQ(read("//X Y Z R G B\n1 2 3 10 20 30\n").colors, (Colors{{10, 20, 30, 255}}));
}

TEST(TextCloud, a_pts_has_counts_before_its_scans_and_intensities_beside_its_colours) {
  const RawCloud cloud = read("2\n1 2 3 -100 10 20 30\n4 5 6 7 40 50 60\n1\n7 8 9 0 0 0 0\n");
  EXPECT_EQ(cloud.positions, (Points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  EXPECT_EQ(cloud.colors, (Colors{{10, 20, 30, 255}, {40, 50, 60, 255}, {0, 0, 0, 255}}));
}

TEST(TextCloud, georeferenced_decimals_are_doubles) {
  EXPECT_EQ(read("412345.678 5654321.123 99.001\n").positions[0], (Point3{412345.678, 5654321.123, 99.001}));
}

TEST(ObjCloud, takes_vertices_with_their_colours_and_leaves_faces_aside) {
  const RawCloud cloud = read(kObj);
  EXPECT_EQ(cloud.positions, (Points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9.25}, {1, 1, 1}}));
  EXPECT_EQ(cloud.colors[0], (Color4{255, 0, 128, 255}));
  EXPECT_THAT(cloud.warnings, ElementsAre(HasSubstr("normals dropped"), HasSubstr("input=mesh")));
}

TEST(ObjCloud, takes_normals_that_stand_beside_the_vertices_of_a_cloud) {
  EXPECT_EQ(read("vn 0 0 1\nv 1 2 3\nvn 1 0 0\nv 4 5 6\n").normals, (std::vector<Normal3>{{0, 0, 1}, {1, 0, 0}}));
}

TEST(ObjMesh, polygons_become_fans_and_negative_indices_count_from_the_end) {
  const auto mesh = decode_mesh(testing::as_bytes(kObj), "hand.obj");
  ASSERT_TRUE(mesh.ok()) << detail_of(mesh);
  EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{triangle(0, 1, 2), triangle(0, 2, 3), triangle(0, 3, 2)}));
}

TEST(StlCloud, binary_and_ascii_give_the_same_corners) {
  for (const std::string& text :
       {binary_stl(two_facets()), binary_stl(two_facets(), "solid misleading"), ascii_stl(two_facets())}) {
    EXPECT_EQ(read(text).positions, (Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}));
  }
}

TEST(StlMesh, equal_corners_are_one_vertex) {
  for (const std::string& text : {binary_stl(two_facets()), ascii_stl(two_facets())}) {
    const auto mesh = decode_mesh(testing::as_bytes(text), "hand.stl");
    ASSERT_TRUE(mesh.ok()) << detail_of(mesh);
    EXPECT_EQ(mesh->positions, (Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5}}));
    EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{triangle(0, 1, 2), triangle(1, 3, 2)}));
  }
}

TEST(PcdCloud, ascii_binary_and_compressed_give_the_same_points) {
  for (const std::string& text : {pcd_ascii(), pcd_binary(), pcd_compressed()}) {
    const RawCloud cloud = without_unmeasured(read(text));
    EXPECT_EQ(cloud.positions, (Points{{1.5, 2, 3.25}, {-1, -2, -3}}));
    EXPECT_EQ(cloud.normals, (std::vector<Normal3>{{0, 0, 1}, {1, 0, 0}}));
    EXPECT_EQ(cloud.colors, (Colors{{1, 2, 3, 255}, {255, 0, 0, 255}}));
  }
}

TEST(PcdCloud, points_without_a_measurement_are_left_out_where_a_cloud_is_made) {
  const auto cloud = make_cloud(read(pcd_ascii()), 1, Missing::drop);
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_EQ(cloud->size(), 2U);
  EXPECT_THAT(cloud->warnings, ElementsAre(HasSubstr("1 of 3 points left out")));
}

TEST(PcdCloud, tells_where_the_sensor_stood_unless_it_says_what_everybody_writes) {
  const auto viewpoint_of = [](const std::string& place, const std::string& size) {
    return parse_cloud(as_bytes("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n" + size + "\nVIEWPOINT " + place +
                                " 1 0 0 0\nDATA ascii\n1 2 3\n4 5 6\n"),
                       "view.pcd");
  };
  const std::string row = "WIDTH 2\nHEIGHT 1";
  EXPECT_EQ(viewpoint_of("1 -2.5 3", row)->source.viewpoint, (Point3{1, -2.5, 3}));
  EXPECT_EQ(viewpoint_of("0 0 0", row)->source.viewpoint, std::nullopt);
  EXPECT_EQ(viewpoint_of("0 0 0", "WIDTH 1\nHEIGHT 2")->source.viewpoint, (Point3{0, 0, 0}));
  EXPECT_EQ(code_of(viewpoint_of("0 nan 0", row)), "malformed_input");
}

TEST(PcdCloud, colours_printed_as_floats_are_their_bits) {
  const std::string text =
      "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
      "ascii\n"
      "1 2 3 2.3418052e-38\n";
  EXPECT_EQ(read(text).colors, (Colors{{255, 0, 0, 255}}));
}

TEST(LasCloud, every_record_format_of_every_version_gives_the_same_points) {
  const std::vector<LasPoint> points{{{1000, -2500, 3}, {65535, 0, 257}}, {{0, 7, -9}, {0, 65535, 0}}};
  for (int format = 0; format <= 10; ++format) {
    for (const int minor : {2, 3, 4}) {
      const RawCloud cloud = read(las_file(points, {.minor = minor, .format = format}));
      EXPECT_EQ(cloud.positions, (Points{{1, -2.5, 3 * 0.001}, {0, 7 * 0.001, -9 * 0.001}})) << format;
      const bool colored = format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
      EXPECT_EQ(cloud.colors, colored ? (Colors{{255, 0, 1, 255}, {0, 255, 0, 255}}) : Colors{}) << format;
    }
  }
}

TEST(LasCloud, colours_of_eight_bits_in_sixteen_are_recognised_and_black_ones_are_none) {
  EXPECT_EQ(read(las_file({{{1, 1, 1}, {255, 16, 0}}})).colors, (Colors{{255, 16, 0, 255}}));
  EXPECT_TRUE(read(las_file({{{1, 1, 1}, {0, 0, 0}}})).colors.empty());
}

TEST(LasCloud, georeferenced_coordinates_keep_their_millimetres_into_a_glb) {
  const std::vector<LasPoint> points{{{0, 0, 0}}, {{100001, 1, 7}}, {{3, 100003, 11}}};
  RawCloud cloud = read(las_file(points, {.format = 0, .offset = {412000, 5654000, 99}}));
  EXPECT_EQ(cloud.positions[1], (Point3{100001 * 0.001 + 412000, 1 * 0.001 + 5654000, 7 * 0.001 + 99}));
  TriangleMesh mesh;
  mesh.positions = cloud.positions;
  mesh.triangles = {triangle(0, 1, 2)};
  const auto back = decode_mesh(encode_mesh(mesh, MeshFormat::glb).value(), "las.glb");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(norm(back->positions[i] - mesh.positions[i]), 1e-5);
}

TEST(GltfCloud, points_lines_and_triangles_are_points_with_their_transform) {
  std::string text(kTwoNodes);
  text.replace(text.find("\"mode\":5"), 8, "\"mode\":0");
  const RawCloud cloud = read(text);
  ASSERT_EQ(cloud.size(), 8U);
  EXPECT_EQ(cloud.positions[5], (Point3{10, 2, 3}));
  EXPECT_EQ(read(kTwoNodes).positions, cloud.positions);
}

TEST(GltfCloud, a_glb_of_ours_gives_back_its_vertices) {
  TriangleMesh mesh = torus_mesh(12, 9);
  for (Point3& p : mesh.positions) p = {p[0] + 5e6, p[1], p[2]};
  for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
    const auto glb = encode_mesh(mesh, MeshFormat::glb, {.quantization_bits = {}, .up = up, .extras_json = {}});
    const auto cloud = parse_cloud(glb.value(), "torus.glb");
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      EXPECT_LT(norm(cloud->positions[i] - mesh.positions[i]), 1e-6);
    }
  }
}

}  // namespace
}  // namespace surfaced
