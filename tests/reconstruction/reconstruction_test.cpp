// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/reconstruction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "reconstruction/input_vertices.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

const MethodInfo& front() { return **find_method("advancing-front"); }

/// A folder of its own that goes away with the test.
class Files : public ::testing::Test {
 protected:
  Files() : folder_(std::filesystem::temp_directory_path() / ("surfaced-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write_cloud(const std::string& name, const std::vector<Point3>& points) const {
    const auto bytes = encode_cloud_ply(points, {}, {});
    EXPECT_TRUE(write_file(folder_ / name, bytes));
    return folder_ / name;
  }

  Result<Json> reconstruct(const std::filesystem::path& cloud, const std::string& mesh,
                           Json parameters = Json::object()) const {
    Context context;
    return reconstruct_file({cloud, folder_ / mesh, &front(), *check_parameters(front(), parameters), {}, {}}, context);
  }

  static std::string bytes_of(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }

  std::filesystem::path folder_;
};

TEST(FindMethod, names_the_methods_there_are) {
  const auto method = find_method("marching-cubes");
  ASSERT_FALSE(method);
  EXPECT_EQ(method.error().code, ErrorCode::unknown_method);
  EXPECT_THAT(method.error().detail, HasSubstr("advancing-front"));
}

TEST(CheckParameters, fills_in_the_defaults_in_the_schema_s_order) {
  const auto parameters = check_parameters(front(), Json::object());
  ASSERT_TRUE(parameters);
  EXPECT_EQ(
      parameters->dump(),
      R"({"radius_ratio_bound":5,"beta":0.52,"openings":"keep","fill_holes":"none","up":"y","quantization":"none",)"
      R"("unit":"mm",)"
      R"("input":"cloud","missing":"drop","truncated":"refuse","columns":"auto","separator":"auto",)"
      R"("decimal":"auto","skip":0,"splat_opacity":"none","splat_scale":"none","fuse":"none",)"
      R"("outliers":"none","sample":"none","sample_cell":"auto","sample_share":0.25,"smooth":"none",)"
      R"("smooth_neighbours":24,"normals":"keep","drop_parts":0,)"
      R"("orient":"auto","simplify":"none","compression":"none","vertex_quality":false,"color_map":"none","min_wall":"auto"})");
}

TEST(CheckParameters, names_the_parameter_the_value_and_what_is_allowed) {
  const auto wrong = check_parameters(front(), Json{{"beta", 4}});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::invalid_parameter);
  EXPECT_THAT(wrong.error().detail, HasSubstr("'beta' is 4; allowed is a number >= 0 and <= 3.14159"));
  const auto unknown = check_parameters(front(), Json{{"gamma", 4}});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::unknown_parameter);
  EXPECT_THAT(unknown.error().detail, HasSubstr("radius_ratio_bound, beta"));
  EXPECT_FALSE(check_parameters(front(), Json::array()));
  EXPECT_FALSE(check_parameters(front(), Json{{"beta", "0.5"}}));
  EXPECT_FALSE(check_parameters(front(), Json{{"quantization", 31}}));
  EXPECT_FALSE(check_parameters(front(), Json{{"quantization", 11.5}}));
  EXPECT_TRUE(check_parameters(front(), Json{{"quantization", 11}}));
}

TEST(ParametersFromText, reads_values_as_the_schema_s_type) {
  const std::vector<std::pair<std::string, std::string>> given{{"beta", "0.25"}, {"quantization", "12"}, {"up", "z"}};
  const auto parameters = parameters_from_text(front(), given);
  ASSERT_TRUE(parameters) << parameters.error().detail;
  EXPECT_EQ(parameters->at("beta"), 0.25);
  EXPECT_EQ(parameters->at("quantization"), 12);
  EXPECT_EQ(parameters->at("up"), "z");
}

TEST(ParametersFromText, refuses_garbage_and_repetition) {
  for (const std::string bad : {"", "abc", "0.5x", "nan", "inf", "1e999", "\xff\xfe"}) {
    const std::vector<std::pair<std::string, std::string>> given{{"beta", bad}};
    const auto parameters = parameters_from_text(front(), given);
    ASSERT_FALSE(parameters) << bad;
    EXPECT_EQ(parameters.error().code, ErrorCode::invalid_parameter);
  }
  const std::vector<std::pair<std::string, std::string>> twice{{"beta", "0.5"}, {"beta", "0.5"}};
  ASSERT_FALSE(parameters_from_text(front(), twice));
}

TEST_F(Files, report_agrees_with_a_recount_of_the_written_mesh) {
  const auto cloud = write_cloud("sphere.ply", testing::sphere_points(600));
  for (const std::string mesh : {"m.glb", "m.gltf", "m.drc", "m.ply", "m.obj", "m.stl", "m.3mf"}) {
    const auto report = reconstruct(cloud, mesh);
    ASSERT_TRUE(report) << mesh << ": " << report.error().detail;
    const auto decoded = read_mesh(folder_ / mesh);
    ASSERT_TRUE(decoded) << mesh << ": " << decoded.error().detail;
    EXPECT_EQ(report->at("mesh").at("triangles"), decoded->triangles.size());
    EXPECT_EQ(report->at("mesh").at("vertices"), 600);
    EXPECT_EQ(report->at("mesh").at("closed"), true);
    EXPECT_EQ(report->at("quality").at("unused_points"), 0);
    EXPECT_EQ(report->at("quality").at("interior_vertices"), 0);
  }
}

/// A sphere of points without a cap of some 50 points across.
std::vector<Point3> open_sphere() {
  std::vector<Point3> points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.8; });
  return points;
}

TEST_F(Files, holes_are_filled_behind_any_method_that_leaves_them_and_counted) {
  const auto cloud = write_cloud("open.ply", open_sphere());
  for (const auto& [id, keep_open] :
       std::vector<std::pair<std::string, Json>>{{"advancing-front", Json{{"radius_ratio_bound", 1.5}, {"beta", 0}}},
                                                 {"local-delaunay", Json{{"max_edge", 3}}},
                                                 {"intrinsic-delaunay", Json{{"max_edge", 3}}}}) {
    const MethodInfo& method = **find_method(id);
    const auto run_with = [&](const std::string& holes) {
      Json parameters = keep_open;
      parameters["fill_holes"] = holes;
      Context context;
      return reconstruct_file(
          {cloud, folder_ / (id + holes + ".glb"), &method, *check_parameters(method, parameters), {}, {}}, context);
    };
    const auto open = run_with("none");
    const auto filled = run_with("all");
    ASSERT_TRUE(open && filled) << id;
    EXPECT_TRUE(open->at("hole_filling").is_null());
    ASSERT_EQ(open->at("mesh").at("closed"), false) << id;
    EXPECT_THAT(open->at("warnings").dump(), HasSubstr("the mesh is open"));
    EXPECT_EQ(filled->at("mesh").at("closed"), true) << id;
    EXPECT_EQ(filled->at("mesh").at("vertex_manifold"), true);
    EXPECT_THAT(filled->at("warnings").dump(), ::testing::Not(HasSubstr("open")));
    const Json& filling = filled->at("hole_filling");
    EXPECT_EQ(filling.at("filled"), filling.at("loops"));
    EXPECT_GT(filling.at("vertices_added"), 20);
    EXPECT_EQ(filled->at("mesh").at("vertices"), open_sphere().size() -
                                                     filled->at("quality").at("unused_points").get<std::size_t>() +
                                                     filling.at("vertices_added").get<std::size_t>());
    EXPECT_NEAR(filled->at("quality").at("volume"), 4.19, 0.03) << id;
    EXPECT_THAT(filled->at("stages").dump(), HasSubstr("fill_holes"));
    if (id == "intrinsic-delaunay") {
      EXPECT_GT(filled->at("method_statistics").at("flips_after_filling"), 0);
      EXPECT_EQ(filled->at("certificate").at("edges_beyond_pi"), filled->at("method_statistics").at("not_flippable"));
    }
    const auto mesh = read_mesh(folder_ / (id + "all.glb"));
    ASSERT_TRUE(mesh);
    for (const Point3& p : mesh->positions) EXPECT_NEAR(norm(p), 1, 0.02);
  }
}

TEST_F(Files, a_certificate_is_in_the_reports_of_intrinsic_delaunay_and_of_measured_meshes) {
  const auto cloud = write_cloud("sphere.ply", testing::sphere_points(3000));
  const auto without = reconstruct(cloud, "front.glb");
  ASSERT_TRUE(without);
  EXPECT_FALSE(without->contains("certificate"));
  const MethodInfo& method = **find_method("intrinsic-delaunay");
  Context context;
  const auto report =
      reconstruct_file({cloud, folder_ / "m.glb", &method, *check_parameters(method, Json::object()), {}, {}}, context);
  ASSERT_TRUE(report);
  const Json& certificate = report->at("certificate");
  EXPECT_EQ(certificate.at("bounds_met"), true);
  EXPECT_EQ(certificate.at("premises").at("injectivity_and_convexity").at("met"), "estimated");
  EXPECT_NEAR(certificate.at("curvature").at("p99").get<double>(), 1, 0.03);
  EXPECT_EQ(certificate.at("bounds_say_nothing_because"), nullptr);
  Context none;
  const auto left_out = reconstruct_file(
      {cloud, folder_ / "n.glb", &method, *check_parameters(method, {{"certificate", "no"}}), {}, {}}, none);
  EXPECT_FALSE(left_out->contains("certificate"));
  Context again(2);
  const auto measured = measure_file(folder_ / "m.glb", std::nullopt, false, again);
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->at("certificate"), certificate);
}

/// A cube of few points: its edges are sharper than any sampling could resolve.
TEST_F(Files, a_certificate_does_not_say_that_bounds_are_met_where_the_theorem_says_nothing) {
  std::vector<Point3> points;
  for (int i = 0; i < 125; ++i) {
    const Point3 p{i % 5 / 4.0, i / 5 % 5 / 4.0, i / 25 / 4.0};
    if (std::ranges::any_of(p, [](double x) { return x == 0 || x == 1; })) points.push_back(p);
  }
  const MethodInfo& method = **find_method("intrinsic-delaunay");
  Context context;
  const auto report = reconstruct_file({write_cloud("cube.ply", points),
                                        folder_ / "cube.glb",
                                        &method,
                                        *check_parameters(method, Json::object()),
                                        {},
                                        {}},
                                       context);
  ASSERT_TRUE(report);
  const Json& certificate = report->at("certificate");
  EXPECT_EQ(certificate.at("premises").at("epsilon_within_curvature").at("met"), false);
  EXPECT_EQ(certificate.at("bounds_met"), nullptr);
  EXPECT_THAT(certificate.at("bounds_say_nothing_because").get<std::string>(), HasSubstr("1/8"));
}

TEST_F(Files, mesh_has_the_same_bytes_for_any_order_of_the_points) {
  std::vector<Point3> points = testing::torus_points(40, 16);
  const auto first = write_cloud("a.ply", points);
  std::ranges::shuffle(points, std::mt19937(3));
  const auto second = write_cloud("b.ply", points);
  ASSERT_TRUE(reconstruct(first, "a.glb"));
  ASSERT_TRUE(reconstruct(second, "b.glb"));
  EXPECT_EQ(bytes_of(folder_ / "a.glb"), bytes_of(folder_ / "b.glb"));
}

TEST_F(Files, stages_cover_the_wall_time_and_start_with_read) {
  const auto report = reconstruct(write_cloud("s.ply", testing::sphere_points(2000)), "s.glb");
  ASSERT_TRUE(report);
  double sum = 0;
  for (const Json& stage : report->at("stages")) sum += stage.at("seconds").get<double>();
  EXPECT_NEAR(sum, report->at("resources").at("wall_seconds").get<double>(), 1e-9);
  EXPECT_EQ(report->at("stages").front().at("name"), "read");
  EXPECT_EQ(report->at("stages").back().at("name"), "write");
}

TEST_F(Files, preparing_stages_count_their_points_and_stand_among_the_stages) {
  std::vector<Point3> points = testing::sphere_points(3000);
  points.push_back({3, 0, 0});
  points.push_back({0, 0, -4});
  const auto report = reconstruct(write_cloud("s.ply", points), "s.glb",
                                  Json{{"outliers", 3}, {"sample", "grid"}, {"sample_cell", 0.1}});
  ASSERT_TRUE(report) << report.error().detail;
  const Json& stages = report->at("preparing");
  ASSERT_EQ(stages.size(), 2U);
  EXPECT_EQ(stages[0].at("points_in"), 3002);
  EXPECT_EQ(stages[0].at("points_out"), 3000);
  EXPECT_LT(stages[1].at("points_out"), 2500);
  EXPECT_EQ(report->at("cloud").at("points"), 3002);
  EXPECT_EQ(report->at("stages")[1].at("name"), "outliers");
  double sum = 0;
  for (const Json& stage : report->at("stages")) sum += stage.at("seconds").get<double>();
  EXPECT_NEAR(sum, report->at("resources").at("wall_seconds").get<double>(), 1e-9);
}

/// Two sheets eight apart, so far from the origin that doubles are four apart: smoothing lays them on each other.
std::vector<Point3> sheets_that_smoothing_merges() {
  constexpr double kFar = 0x1p54;
  std::vector<Point3> points;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      for (const int side : {-4, 4}) points.push_back({kFar + 4096 * i, kFar + 4096 * j, kFar + side});
    }
  }
  return points;
}

TEST_F(Files, warnings_of_preparing_stages_are_in_the_report) {
  const auto report =
      reconstruct(write_cloud("s.ply", sheets_that_smoothing_merges()), "s.ply.glb", Json{{"smooth", "jet"}});
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_THAT(report->at("warnings").dump(), HasSubstr("duplicate points merged"));
}

TEST(Run, prepares_the_cloud_as_a_file_s) {
  Context context;
  const auto cloud = make_cloud(testing::raw_cloud(testing::sphere_points(2000)));
  const auto parameters = check_parameters(front(), Json{{"sample", "grid"}, {"sample_cell", 0.2}});
  const auto result = run(*cloud, front(), *parameters, context);
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_LT(result->mesh.positions.size(), 1000U);
  const auto merged = run(*make_cloud(testing::raw_cloud(sheets_that_smoothing_merges())), front(),
                          *check_parameters(front(), Json{{"smooth", "jet"}}), context);
  ASSERT_TRUE(merged) << merged.error().detail;
  EXPECT_THAT(merged->warnings, ::testing::Contains(HasSubstr("duplicate points merged")));
}

/// Every entry names a vertex at the input point's place; a point without one lies on no vertex at all.
void expect_right(const PointCloud& cloud, const Reconstruction& made, const std::vector<Point3>& points) {
  const std::vector<VertexIndex> of_input = vertices_of_input(cloud, made.mesh);
  ASSERT_EQ(of_input.size(), points.size());
  const std::set<Point3> vertices(made.mesh.positions.begin(), made.mesh.positions.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const VertexIndex v = of_input[i];
    ASSERT_EQ(v.valid(), vertices.contains(points[i])) << i;
    if (v.valid()) {
      ASSERT_EQ(made.mesh.positions.at(v), points[i]) << i;
    }
  }
}

TEST(Run, tells_the_vertex_of_every_input_point_of_any_method) {
  Context context;
  std::vector<Point3> points = testing::sphere_points(1000);
  for (int i = 0; i < 20; ++i)
    points.insert(points.begin(), Point3{i * 0.01, 0.02, 0.01 * (i % 7)});  // inside, and unused
  points.push_back(points[500]);
  const auto cloud = make_cloud(testing::raw_cloud(points));
  for (const char* id : {"minimum-boundary", "local-delaunay", "advancing-front", "poisson"}) {
    SCOPED_TRACE(id);
    const MethodInfo& method = **find_method(id);
    const auto made = run(*cloud, method, *check_parameters(method, Json::object()), context);
    ASSERT_TRUE(made) << made.error().detail;
    expect_right(*cloud, *made, points);
  }
}

TEST(Run, tells_the_vertex_of_every_input_point_whatever_the_stages_did) {
  Context context;
  const std::vector<Point3> points = testing::sphere_points(1000);
  const auto cloud = make_cloud(testing::raw_cloud(points));
  for (const Json& stages : {Json{{"sample", "grid"}}, Json{{"smooth", "jet"}}, Json{{"simplify", 500}}}) {
    SCOPED_TRACE(stages.dump());
    const auto made = run(*cloud, front(), *check_parameters(front(), stages), context);
    ASSERT_TRUE(made) << made.error().detail;
    if (!stages.contains("smooth")) {
      EXPECT_LT(made->mesh.positions.size(), points.size());
    }
    expect_right(*cloud, *made, points);
  }
}

TEST(MethodJson, says_of_every_method_that_stages_act_before_and_after_it) {
  for (const Json& method : methods_json()) {
    EXPECT_THAT(method.at("limitations").back().get<std::string>(), HasSubstr("simplify")) << method.at("id");
  }
}

TEST_F(Files, every_preparing_stage_runs_before_any_method_and_is_counted) {
  const auto cloud = write_cloud("torus.ply", testing::random_torus(3000, 4, 0.01));
  const Json all{
      {"outliers", 3}, {"sample", "hierarchy"}, {"sample_share", 0.5}, {"smooth", "bilateral"}, {"normals", "jet"}};
  const auto report = reconstruct(cloud, "t.glb", all);
  ASSERT_TRUE(report) << report.error().detail;
  const Json& stages = report->at("preparing");
  ASSERT_EQ(stages.size(), 4U);
  EXPECT_EQ(stages[1].at("name"), "sample");
  EXPECT_GT(stages[1].at("points_out"), 1000);
  EXPECT_LT(stages[1].at("points_out"), 2500);
  EXPECT_EQ(stages[3].at("name"), "normals");
  EXPECT_EQ(report->at("quality").at("interior_vertices"), nullptr) << "the points moved";
  const auto mesh = read_mesh(folder_ / "t.glb");
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->normals.size(), mesh->positions.size());
}

TEST_F(Files, small_parts_are_dropped_where_asked_for) {
  std::vector<Point3> points = testing::sphere_points(800);
  for (const Point3& p : testing::sphere_points(60, {5, 0, 0}, 0.3)) points.push_back(p);
  const auto cloud = write_cloud("two.ply", points);
  EXPECT_EQ(reconstruct(cloud, "two.glb")->at("mesh").at("components"), 2);
  const auto one = reconstruct(cloud, "one.glb", Json{{"drop_parts", 0.5}});
  EXPECT_EQ(one->at("mesh").at("components"), 1);
  const Json& stage = one->at("finishing").at(0);
  EXPECT_EQ(stage.at("name"), "drop_parts");
  EXPECT_GT(stage.at("triangles_in"), stage.at("triangles_out"));
  EXPECT_EQ(stage.at("triangles_out"), one->at("mesh").at("triangles"));
}

TEST_F(Files, the_printing_section_says_unit_and_extent) {
  const auto report = reconstruct(write_cloud("s.ply", testing::sphere_points(500)), "s.3mf", Json{{"unit", "cm"}});
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_EQ(report->at("printing").at("unit"), "cm");
  EXPECT_NEAR(report->at("printing").at("bounding_box")[2].get<double>(), 2, 0.01);
  EXPECT_EQ(report->at("printing").at("volume"), report->at("quality").at("volume"));
}

TEST_F(Files, quantised_draco_reports_its_error_within_the_step_of_its_grid) {
  const auto cloud = write_cloud("s.ply", testing::sphere_points(500));
  const auto report = reconstruct(cloud, "q.drc", Json{{"quantization", 10}});
  ASSERT_TRUE(report) << report.error().detail;
  const double error = report->at("encoding").at("max_error");
  EXPECT_GT(error, 0);
  EXPECT_LT(error, 2.0 / 1023 * std::sqrt(3.0));
}

TEST_F(Files, whoever_is_told_how_many_points_there_are_may_end_the_run_before_the_method_begins) {
  auto points = testing::sphere_points(100);
  points.push_back(points.front());
  const auto cloud = write_cloud("told.ply", points);
  std::size_t told = 0;
  const auto refuse = [&](std::size_t distinct) -> Status {
    told = distinct;
    return Error{ErrorCode::storage_full, "no room"};
  };
  Context context;
  const auto report = reconstruct_file({.cloud = cloud,
                                        .mesh = folder_ / "told.glb",
                                        .method = &front(),
                                        .parameters = *check_parameters(front(), Json::object()),
                                        .on_read = refuse},
                                       context);
  EXPECT_EQ(told, 100U);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().detail, "no room");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "told.glb"));
}

TEST(MostCost, grows_with_the_points_of_a_cloud_by_a_thousand_times_what_each_usually_takes) {
  for (const MethodInfo& method : methods()) {
    const Cost few = most_cost(method, 1);
    const Cost many = most_cost(method, 1'000'001);
    EXPECT_GE(few.seconds, 10) << method.id;
    EXPECT_LE(few.seconds, 11) << method.id;
    const double usual = (many.seconds - few.seconds) / 1e9;
    EXPECT_GE(usual, 5e-6) << method.id << ": no method takes as little for a point";
    EXPECT_LE(usual, 1e-3) << method.id << ": or as much";
    EXPECT_GE(many.bytes - few.bytes, std::uint64_t{100'000'000'000}) << method.id;
  }
}

TEST_F(Files, refused_cloud_leaves_no_mesh_behind) {
  const auto report = reconstruct(write_cloud("two.ply", {{0, 0, 0}, {1, 1, 1}}), "two.glb");
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::too_few_points);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "two.glb"));
}

TEST_F(Files, measure_counts_points_of_a_cloud_that_the_mesh_leaves_out) {
  std::vector<Point3> points = testing::sphere_points(400);
  ASSERT_TRUE(reconstruct(write_cloud("s.ply", points), "s.glb"));
  points.push_back({0, 0, 0});
  points.push_back({3, 0, 0});
  const auto cloud = write_cloud("more.ply", points);
  Context context;
  const auto report = measure_file(folder_ / "s.glb", cloud, true, context);
  ASSERT_TRUE(report) << report.error().detail;
  EXPECT_EQ(report->at("quality").at("unused_points"), 2);
  EXPECT_EQ(report->at("quality").at("interior_vertices"), 1);
  EXPECT_EQ(report->at("quality").at("self_intersections"), 0);
}

}  // namespace
}  // namespace surfaced
