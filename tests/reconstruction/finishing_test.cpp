// SPDX-License-Identifier: GPL-3.0-or-later
// What happens to a mesh behind the method: simplifying, colours, packing, walls; through the façade.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "quality/quality.hpp"
#include "reconstruction/reconstruction.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const MethodInfo& front() { return **find_method("advancing-front"); }

class Finishing : public ::testing::Test {
 protected:
  std::filesystem::path cloud_of(const std::vector<Point3>& points) const {
    EXPECT_TRUE(write_file(folder_.path() / "cloud.ply", encode_cloud_ply(points, {}, {})));
    return folder_.path() / "cloud.ply";
  }

  Result<Json> reconstruct(const std::filesystem::path& cloud, const std::string& mesh, const Json& given,
                           const MethodInfo& method = front()) const {
    Context context;
    auto parameters = check_parameters(method, given);
    EXPECT_TRUE(parameters) << parameters.error().detail;
    return reconstruct_file({cloud, folder_.path() / mesh, &method, *parameters, {}, {}}, context);
  }

  std::vector<std::byte> bytes_of(const std::string& mesh) const {
    const auto decoded = read_mesh(folder_.path() / mesh);
    EXPECT_TRUE(decoded) << decoded.error().detail;
    return encode_mesh(*decoded, MeshFormat::ply).value();
  }

  testing::TemporaryDirectory folder_;
};

/// As the points of a PLY: float32.
std::vector<Point3> narrow_sphere(std::size_t count) {
  std::vector<Point3> points = testing::sphere_points(count);
  for (Point3& p : points) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  return points;
}

TEST_F(Finishing, simplify_gives_at_most_so_many_triangles_with_counts_and_distance_in_the_report) {
  const auto report = reconstruct(cloud_of(narrow_sphere(2000)), "s.glb", Json{{"simplify", 500}});
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_LE(report->at("mesh").at("triangles"), 500);
  EXPECT_GT(report->at("mesh").at("triangles"), 490);
  EXPECT_EQ(report->at("mesh").at("closed"), true);
  EXPECT_EQ(report->at("mesh").at("genus"), 0);
  EXPECT_TRUE(report->at("quality").at("interior_vertices").is_null());
  EXPECT_EQ(report->at("encoding").at("max_error"), 0) << "new vertices are float32 where the points are";
  const Json& stage = report->at("finishing").at(0);
  EXPECT_EQ(stage.at("name"), "simplify");
  EXPECT_EQ(stage.at("triangles_in"), 3996);
  EXPECT_EQ(stage.at("vertices_in"), 2000);
  EXPECT_EQ(stage.at("vertices_out"), report->at("mesh").at("vertices"));
  EXPECT_GT(stage.at("max_distance"), 0);
  EXPECT_LT(stage.at("max_distance"), 0.05);
  EXPECT_EQ(stage.at("self_intersections"), 0);
  EXPECT_THAT(report->at("warnings").dump(), Not(HasSubstr("cross")));
}

TEST_F(Finishing, simplify_warns_of_triangles_that_cross_and_counts_them_as_quality_does) {
  const auto report = reconstruct(cloud_of(testing::torus_points(90, 24)), "crossing.ply", Json{{"simplify", 18}});
  ASSERT_TRUE(report) << report.error().detail;
  const auto mesh = read_mesh(folder_.path() / "crossing.ply");
  ASSERT_TRUE(mesh);
  const std::size_t crossing = report->at("finishing").at(0).at("self_intersections");
  EXPECT_GT(crossing, 0U);
  EXPECT_EQ(crossing, count_self_intersections(*mesh));
  EXPECT_THAT(report->at("warnings").dump(), HasSubstr(std::to_string(crossing) + " pairs of triangles"));
}

TEST_F(Finishing, simplify_keeps_within_a_fraction_of_the_diagonal_and_is_the_same_in_every_run) {
  const auto cloud = cloud_of(narrow_sphere(2000));
  const auto report = reconstruct(cloud, "a.glb", Json{{"simplify", 0.005}});
  ASSERT_TRUE(report) << report.error().detail;
  const double distance = report->at("finishing").at(0).at("max_distance");
  EXPECT_LE(distance, 0.005 * std::sqrt(12.0));
  EXPECT_LT(report->at("mesh").at("triangles"), 2000);
  ASSERT_TRUE(reconstruct(cloud, "b.glb", Json{{"simplify", 0.005}}));
  EXPECT_EQ(bytes_of("a.glb"), bytes_of("b.glb"));
}

TEST_F(Finishing, simplify_takes_a_count_or_a_fraction_and_nothing_between) {
  for (const double wrong : {0.0, 0.6, 1.0, 3.0, 4.5, -5.0, 4294967296.0, 1e20}) {
    EXPECT_FALSE(check_parameters(front(), Json{{"simplify", wrong}})) << wrong;
  }
  for (const double right : {0.001, 0.5, 4.0, 1e9, 4294967295.0}) {
    EXPECT_TRUE(check_parameters(front(), Json{{"simplify", right}})) << right;
  }
}

TEST_F(Finishing, simplify_to_more_triangles_than_there_are_changes_nothing) {
  const auto cloud = cloud_of(narrow_sphere(500));
  ASSERT_TRUE(reconstruct(cloud, "plain.glb", Json::object()));
  const auto report = reconstruct(cloud, "same.glb", Json{{"simplify", 4294967295}});
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_EQ(report->at("finishing").at(0).at("max_distance"), 0);
  EXPECT_EQ(bytes_of("same.glb"), bytes_of("plain.glb"));
}

TEST_F(Finishing, every_packing_of_a_glb_holds_the_same_mesh_and_says_what_it_is) {
  const auto cloud = cloud_of(narrow_sphere(1500));
  ASSERT_TRUE(reconstruct(cloud, "none.glb", Json::object()));
  const auto plain = read_mesh(folder_.path() / "none.glb");
  ASSERT_TRUE(plain);
  for (const std::string compression : {"draco", "meshopt"}) {
    for (const std::string extension : {".glb", ".gltf"}) {
      const std::string name = compression + extension;
      const auto report = reconstruct(cloud, name, Json{{"compression", compression}, {"vertex_quality", true}});
      ASSERT_TRUE(report) << report.error().detail;
      EXPECT_EQ(report->at("encoding").at("compression"), compression);
      EXPECT_EQ(report->at("encoding").at("max_error"), 0);
      auto packed = read_mesh(folder_.path() / name);
      ASSERT_TRUE(packed) << packed.error().detail;
      EXPECT_EQ(packed->positions, plain->positions);
      sort_triangles(*packed);
      EXPECT_EQ(packed->triangles, plain->triangles);
      const auto coarse = reconstruct(cloud, "q" + name, Json{{"compression", compression}, {"quantization", 10}});
      ASSERT_TRUE(coarse) << coarse.error().detail;
      EXPECT_GT(coarse->at("encoding").at("max_error"), 1e-5);
      EXPECT_LT(coarse->at("encoding").at("max_error"), 4e-3);
      EXPECT_LT(coarse->at("encoding").at("bytes"), report->at("encoding").at("bytes"));
    }
  }
}

TEST_F(Finishing, packing_that_a_format_does_not_know_is_a_warning) {
  const auto cloud = cloud_of(narrow_sphere(300));
  const auto warnings = [&](const std::string& mesh, const Json& given) {
    return reconstruct(cloud, mesh, given).value().at("warnings");
  };
  EXPECT_THAT(warnings("p.glb", Json{{"quantization", 12}}),
              Contains(HasSubstr("quantization=12 changes nothing in glb")));
  EXPECT_THAT(warnings("p.stl", Json{{"quantization", 12}}), Contains(HasSubstr("changes nothing in stl")));
  EXPECT_THAT(warnings("p.ply", Json{{"compression", "draco"}}),
              Contains(HasSubstr("compression=draco changes nothing")));
  EXPECT_THAT(warnings("p.drc", Json{{"quantization", 12}}), Not(Contains(HasSubstr("changes nothing"))));
}

TEST_F(Finishing, a_colour_map_colours_the_vertices_by_their_worst_triangle) {
  const auto report = reconstruct(cloud_of(narrow_sphere(800)), "c.ply", Json{{"color_map", "r_over_l"}});
  ASSERT_TRUE(report) << report.error().detail;
  const auto mesh = read_mesh(folder_.path() / "c.ply");
  ASSERT_TRUE(mesh);
  const VertexQuality quality = vertex_quality(*mesh);
  ASSERT_EQ(mesh->colors.size(), 800U);
  const auto [least, greatest] = std::ranges::minmax_element(quality.inradius_to_longest_edge);
  const Color4& dark = mesh->colors[static_cast<std::size_t>(least - quality.inradius_to_longest_edge.begin())];
  const Color4& bright = mesh->colors[static_cast<std::size_t>(greatest - quality.inradius_to_longest_edge.begin())];
  EXPECT_LT(dark[1], bright[1]) << "green grows along viridis";
}

/// A grid of points on the faces of a box; step divides the sides.
std::vector<Point3> box_points(const Point3& size, double step) {
  std::vector<Point3> points;
  const auto steps = [&](std::size_t axis) { return static_cast<int>(std::lround(size[axis] / step)); };
  for (int x = 0; x <= steps(0); ++x) {
    for (int y = 0; y <= steps(1); ++y) {
      for (int z = 0; z <= steps(2); ++z) {
        const bool rim = x == 0 || x == steps(0) || y == 0 || y == steps(1) || z == 0 || z == steps(2);
        if (rim) points.push_back({x * step, y * step, z * step});
      }
    }
  }
  return points;
}

TEST_F(Finishing, a_plate_that_printers_may_not_hold_is_warned_of_in_its_unit) {
  const auto plate = cloud_of(box_points({8, 8, 0.5}, 0.25));
  const MethodInfo& closed = **find_method("minimum-boundary");  // a grid is all ties, which the front may leave open
  const auto thin = reconstruct(plate, "p.3mf", Json::object(), closed);
  ASSERT_TRUE(thin) << thin.error().detail;
  const Json& walls = thin->at("printing").at("walls");
  ASSERT_TRUE(walls.is_object()) << thin->at("mesh").dump();
  EXPECT_EQ(walls.at("limit"), 0.8);
  EXPECT_NEAR(walls.at("p50").get<double>(), 0.5, 1e-9);
  EXPECT_GT(walls.at("thinner"), 0.8) << "all but the narrow sides";
  EXPECT_THAT(thin->at("warnings"), Contains(HasSubstr("walls thinner than 0.8 mm")));
  const auto thick = reconstruct(plate, "p.stl", Json{{"unit", "cm"}}, closed);
  EXPECT_THAT(thick->at("warnings"), Not(Contains(HasSubstr("walls"))));
  EXPECT_TRUE(reconstruct(plate, "p.glb", Json::object(), closed)->at("printing").at("walls").is_null());
  EXPECT_EQ(reconstruct(plate, "q.glb", Json{{"min_wall", 0.6}}, closed)->at("printing").at("walls").at("limit"), 0.6);
}

TEST_F(Finishing, the_error_in_the_report_is_the_one_a_reader_finds_in_every_format) {
  std::vector<Point3> points = testing::sphere_points(300, {412345.678, 5654321.123, 123.456}, 50);
  const auto cloud = cloud_of(points);
  for (const std::string format : {"glb", "gltf", "drc", "ply", "obj", "stl", "3mf"}) {
    const auto report = reconstruct(cloud, "far." + format, Json::object());
    ASSERT_TRUE(report) << format << ": " << report.error().detail;
    const auto mesh = read_mesh(folder_.path() / ("far." + format));
    ASSERT_TRUE(mesh) << format << ": " << mesh.error().detail;
    double found = 0;
    for (const Point3& v : mesh->positions) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Point3& p : points) nearest = std::min(nearest, norm(v - p));
      found = std::max(found, nearest);
    }
    EXPECT_DOUBLE_EQ(report->at("encoding").at("max_error"), found) << format;
    const bool keeps_doubles = format == "drc" || format == "ply" || format == "obj";
    EXPECT_EQ(found == 0, keeps_doubles) << format;
    EXPECT_LT(found, 1e-5) << format;
  }
}

TEST_F(Finishing, a_mesh_encoded_again_says_what_both_encodings_did) {
  ASSERT_TRUE(reconstruct(cloud_of(narrow_sphere(300)), "m.glb", Json::object()));
  const auto mesh = read_mesh(folder_.path() / "m.glb");
  ASSERT_TRUE(mesh);
  const Json report{{"encoding", {{"max_error", 0.25}}}, {"stages", Json::array()}};
  const auto bytes = encode_again(*mesh, MeshFormat::gltf, Json{{"compression", "draco"}, {"quantization", 8}}, report);
  ASSERT_TRUE(bytes) << bytes.error().detail;
  const Json gltf = Json::parse(reinterpret_cast<const char*>(bytes->data()),
                                reinterpret_cast<const char*>(bytes->data() + bytes->size()));
  const Json& extras = gltf.at("asset").at("extras");
  EXPECT_GT(extras.at("encoding").at("max_error"), 0.25);
  EXPECT_EQ(extras.at("encoding").at("compression"), "draco");
  EXPECT_FALSE(extras.contains("stages"));
}

}  // namespace
}  // namespace surfaced
