// SPDX-License-Identifier: GPL-3.0-or-later
// docs/adding-a-method.md, followed: the page's listing with a table of methods that has it.
#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "reconstruction/method_table.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {

Method box_method();

// Takes the place of core/reconstruction/method_table.cpp: the linker looks into the library for what is missing alone.
std::vector<Method> all_methods() { return {advancing_front_method(), box_method()}; }

namespace {

using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(AddingAMethod, the_listing_of_the_page_is_what_is_compiled_here) {
  const std::filesystem::path source = SURFACED_SOURCE;
  EXPECT_THAT(text_of(source / "docs/adding-a-method.md"),
              HasSubstr("```cpp\n" + text_of(source / "tests/adding_a_method/box_method.cpp") + "```\n"));
}

TEST(AddingAMethod, the_facade_knows_the_method_and_its_parameters) {
  ASSERT_EQ(methods().size(), 2U);
  const auto box = find_method("box");
  ASSERT_TRUE(box.ok());
  EXPECT_EQ(check_parameters(**box, Json::object()).value().at("margin"), 0);
  EXPECT_EQ(check_parameters(**box, Json{{"margin", 11}}).error().code, ErrorCode::invalid_parameter);
  EXPECT_THAT(methods_json().dump(), HasSubstr("Space around the points"));
}

TEST(AddingAMethod, a_file_becomes_a_mesh_with_a_measured_report) {
  const testing::TemporaryDirectory folder;
  ASSERT_TRUE(write_file(folder.path() / "cloud.ply", encode_cloud_ply(testing::sphere_points(500), {}, {})).ok());
  const MethodInfo* const box = find_method("box").value();
  const Json parameters = check_parameters(*box, Json{{"margin", 0.5}}).value();
  Context context;
  const auto report = reconstruct_file({.cloud = folder.path() / "cloud.ply",
                                        .mesh = folder.path() / "box.glb",
                                        .method = box,
                                        .parameters = parameters,
                                        .limits = {},
                                        .cloud_name = {}},
                                       context);
  ASSERT_TRUE(report.ok()) << report.error().detail;
  EXPECT_EQ(report->at("mesh").at("closed"), true);
  EXPECT_EQ(report->at("mesh").at("oriented"), true);
  EXPECT_EQ(report->at("mesh").at("triangles"), 12);
  EXPECT_EQ(report->at("quality").at("unused_points"), 500);
  const auto& extent = report->at("method_statistics").at("extent");
  const double volume = 8 * extent[0].get<double>() * extent[1].get<double>() * extent[2].get<double>();
  EXPECT_NEAR(report->at("quality").at("volume").get<double>(), volume, 1e-5 * volume);
}

TEST(AddingAMethod, an_error_of_the_method_is_the_error_of_the_run) {
  std::vector<Point3> flat = testing::sphere_points(50);
  for (Point3& p : flat) p[2] = 0;
  const auto cloud = make_cloud({.positions = flat, .normals = {}, .colors = {}, .warnings = {}});
  ASSERT_TRUE(cloud.ok());
  const MethodInfo* const box = find_method("box").value();
  Context context;
  EXPECT_EQ(run(*cloud, *box, check_parameters(*box, Json::object()).value(), context).error().code,
            ErrorCode::coplanar);
}

}  // namespace
}  // namespace surfaced
