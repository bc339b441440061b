// SPDX-License-Identifier: GPL-3.0-or-later
// Parameters of any method that say how a file is read, and warnings of what is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>

#include "reconstruction/reconstruction.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

class Reading : public ::testing::Test {
 protected:
  Result<Json> reconstruct(const std::filesystem::path& file, const Json& parameters = Json::object(),
                           const char* method = "advancing-front") {
    const MethodInfo& info = **find_method(method);
    const Result<Json> checked = check_parameters(info, parameters);
    if (!checked) return checked.error();
    Context context;
    return reconstruct_file({file, folder_.path() / "m.ply", &info, *checked, {}, {}}, context);
  }

  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }

  std::filesystem::path write(const std::string& name, const std::vector<std::byte>& bytes) {
    return write(name, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }

  testing::TemporaryDirectory folder_;
};

std::vector<std::string> warnings_of(const Json& report) {
  return report.at("warnings").get<std::vector<std::string>>();
}

TEST_F(Reading, points_without_a_measurement_are_left_out_and_counted_or_refused_by_file_and_point) {
  std::vector<Point3> points = testing::sphere_points(500);
  points.insert(points.begin() + 7, Point3{0, std::numeric_limits<double>::quiet_NaN(), 0});
  const auto file = write("five.ply", encode_cloud_ply(points, {}, {}));
  const auto report = reconstruct(file);
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_EQ(report->at("cloud").at("points"), 501);
  EXPECT_EQ(report->at("cloud").at("missing_points"), 1);
  EXPECT_THAT(warnings_of(*report), Contains(HasSubstr("1 of 501 points left out")));
  const auto refused = reconstruct(file, {{"missing", "refuse"}});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("five.ply: point 7: y = "));
  EXPECT_THAT(refused.error().detail, HasSubstr("missing=drop"));
}

TEST_F(Reading, columns_of_a_text_are_told_by_parameters_and_stand_in_the_report) {
  std::string text;
  for (const Point3& p : testing::sphere_points(400)) {
    text += std::to_string(p[2]) + ";" + std::to_string(p[0]) + ";7;" + std::to_string(p[1]) + "\n";
  }
  const auto report = reconstruct(write("table.txt", text), {{"columns", "z,x,-,y"}, {"separator", ";"}});
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_EQ(report->at("cloud").at("format"), "text");
  const Json expected = {{"columns", {"z", "x", "-", "y"}},
                         {"separator", "semicolon"},
                         {"decimal", "point"},
                         {"skipped_lines", 0},
                         {"guessed", false}};
  EXPECT_EQ(report->at("cloud").at("table"), expected);
  EXPECT_NEAR(report->at("quality").at("volume").get<double>(), 4.1, 0.2);
}

TEST_F(Reading, columns_that_are_no_list_of_names_are_refused_before_anything_is_read) {
  for (const char* columns : {"x,y", "x,y,z,", "a,b,c", "", "x;y;z", "x,y,z,x,x"}) {
    const auto refused = reconstruct(folder_.path() / "none.txt", {{"columns", columns}});
    ASSERT_FALSE(refused) << columns;
    EXPECT_THAT(name_of(refused.error().code), ::testing::AnyOf("invalid_parameter", "input_unreadable")) << columns;
  }
  EXPECT_EQ(reconstruct(folder_.path() / "none.txt", {{"columns", "a,b,c"}}).error().code,
            ErrorCode::invalid_parameter);
}

TEST_F(Reading, a_mesh_that_is_kept_is_only_finished_measured_and_written) {
  const TriangleMesh torus = testing::torus_mesh(40, 16);
  for (const MeshFormat format : {MeshFormat::obj, MeshFormat::stl, MeshFormat::glb}) {
    const auto file = write("torus." + std::string(name_of(format)), encode_mesh(torus, format).value());
    const auto report = reconstruct(file, {{"input", "mesh"}});
    ASSERT_TRUE(report) << report.error().detail;
    EXPECT_EQ(report->at("mesh").at("triangles"), torus.triangles.size());
    EXPECT_EQ(report->at("mesh").at("genus"), 1);
    EXPECT_EQ(report->at("cloud").at("faces"), torus.triangles.size());
    EXPECT_THAT(warnings_of(*report), Contains(HasSubstr("no method has run")));
    const auto smaller = reconstruct(file, {{"input", "mesh"}, {"simplify", 200}});
    ASSERT_TRUE(smaller) << smaller.error().detail;
    EXPECT_LE(smaller->at("mesh").at("triangles").get<int>(), 200);
    EXPECT_THAT(warnings_of(*reconstruct(file)), Contains(HasSubstr("input=mesh")));
  }
  const auto points = reconstruct(write("points.xyz", std::string("1 2 3\n4 5 6\n")), {{"input", "mesh"}});
  ASSERT_FALSE(points);
  EXPECT_THAT(points.error().detail, HasSubstr("points and no triangles"));
}

TEST_F(Reading, several_scans_of_one_thing_are_said_and_fused_if_that_is_wanted) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-1e-6, 1e-6);
  std::vector<Point3> points;
  for (int scan = 0; scan < 5; ++scan) {
    for (const Point3& p : testing::sphere_points(500))
      points.push_back({p[0] + off(random), p[1] + off(random), p[2] + off(random)});
  }
  const auto file = write("scans.ply", encode_cloud_ply(points, {}, {}));
  EXPECT_THAT(warnings_of(*reconstruct(file)), Contains(HasSubstr("fuse=auto")));
  // A method that fails of them says so.
  const auto failed = reconstruct(file, Json::object(), "poisson");
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().detail, HasSubstr("fuse=auto"));
  for (const Json& fuse : {Json("auto"), Json(0.001)}) {
    const auto report = reconstruct(file, {{"fuse", fuse}});
    ASSERT_TRUE(report) << report.error().detail;
    EXPECT_EQ(report->at("preparing")[0], (Json{{"name", "fuse"}, {"points_in", 2500}, {"points_out", 500}}));
    EXPECT_NEAR(report->at("quality").at("volume").get<double>(), 4.1, 0.1);
  }
}

TEST_F(Reading, steps_of_float32_are_said_where_they_matter) {
  std::vector<Point3> points = testing::sphere_points(1000);
  for (Point3& p : points) p = {10 * p[0] + 432100, 10 * p[1] + 5431200, 10 * p[2] + 318};
  EXPECT_THAT(warnings_of(*reconstruct(write("double.ply", encode_cloud_ply(points, {}, {})))),
              Each(Not(HasSubstr("float32"))));
  for (Point3& p : points) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  EXPECT_THAT(warnings_of(*reconstruct(write("float.ply", encode_cloud_ply(points, {}, {})))),
              Contains(HasSubstr("steps of 0.5, those of float32")));
}

TEST_F(Reading, a_line_in_any_direction_is_called_one_although_rounding_bends_it) {
  std::vector<Point3> line;
  std::vector<Point3> band;
  for (int i = 0; i < 50; ++i) {
    const double t = 0.0371 * i;
    const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    line.push_back({rounded(0.1 + 0.3 * t), rounded(7 - 0.77 * t), rounded(0.123 * t)});
    band.push_back(line.back());
    band.push_back({line.back()[0], line.back()[1], rounded(line.back()[2] + 0.01)});
  }
  const auto refused = reconstruct(write("line.ply", encode_cloud_ply(line, {}, {})));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::collinear);
  EXPECT_TRUE(reconstruct(write("band.ply", encode_cloud_ply(band, {}, {}))));
  // A text is rounded to decimals; a rod of few of its steps is none.
  std::string text;
  std::string rod;
  for (int i = 0; i < 50; ++i) {
    text += std::to_string(i * 0.0371) + " " + std::to_string(7 - 0.77 * i) + " " + std::to_string(0.123 * i) + "\n";
    for (const char* side : {" 0 0\n", " 1 0\n", " 0 1\n", " 1 1\n"}) rod += std::to_string(2 * i) + side;
  }
  EXPECT_EQ(reconstruct(write("line.xyz", text)).error().code, ErrorCode::collinear);
  EXPECT_TRUE(reconstruct(write("rod.xyz", rod)));
}

}  // namespace
}  // namespace surfaced
