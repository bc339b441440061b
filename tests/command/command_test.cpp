// SPDX-License-Identifier: GPL-3.0-or-later
// The command as a user meets it: exit codes, problems on stderr, and what bad input costs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command/command_run.hpp"
#include "io/io.hpp"
#include "support/limited_child.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using testing::Command;
using ::testing::HasSubstr;
using testing::Ran;
using testing::read_all;
namespace fs = std::filesystem;

std::string ply(const std::string& format, const std::string& count, const std::string& type, const std::string& body) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + count + "\nproperty " + type + " x\nproperty " + type +
         " y\nproperty " + type + " z\nend_header\n" + body;
}

TEST_F(Command, writes_a_mesh_and_a_report_and_says_nothing_else) {
  const Ran ran = run({"reconstruct", sphere(), "-o", folder_ / "m.glb", "--report", folder_ / "r.json"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out + ran.err, "");
  const auto report = nlohmann::json::parse(read_all(folder_ / "r.json"));
  EXPECT_EQ(report.at("method"), "minimum-boundary");
  EXPECT_EQ(report.at("mesh").at("closed"), true);
  EXPECT_EQ(report.at("mesh").at("genus"), 0);
  const Ran measured = run({"measure", folder_ / "m.glb", "--cloud", folder_ / "sphere.ply"});
  EXPECT_EQ(measured.exit_code, 0) << measured.err;
  EXPECT_EQ(nlohmann::json::parse(measured.out).at("mesh"), report.at("mesh"));
}

TEST_F(Command, tells_people_at_a_terminal_what_was_made_and_what_to_beware_of) {
  std::vector<Point3> bowl = testing::sphere_points(2000);
  std::erase_if(bowl, [](const Point3& p) { return p[2] > 0; });
  const auto bytes = encode_cloud_ply(bowl, {}, {});
  const fs::path cloud = write("bowl.ply", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const std::string command = std::string(SURFACED_BINARY) + " reconstruct " + cloud.string() + " -o " +
                              (folder_ / "m.glb").string() + " --method local-delaunay --param max_edge=3";
  ASSERT_EQ(std::system(("script -qec '" + command + "' /dev/null > " + (folder_ / "seen").string()).c_str()), 0);
  const std::string seen = read_all(folder_ / "seen");
  EXPECT_NE(seen.find("m.glb: " + std::to_string(bowl.size()) + " vertices, "), std::string::npos) << seen;
  EXPECT_NE(seen.find("triangles, open"), std::string::npos) << seen;
  EXPECT_NE(seen.find("warning: the mesh is open"), std::string::npos) << seen;
}

/// What a person sees who types this, and the exit code.
std::pair<int, std::string> at_a_terminal(const fs::path& folder, const std::string& arguments) {
  const std::string command = std::string(SURFACED_BINARY) + " " + arguments;
  const int status = std::system(("script -qec '" + command + "' /dev/null > " + (folder / "seen").string()).c_str());
  std::string seen = read_all(folder / "seen");
  std::erase(seen, '\r');
  return {WEXITSTATUS(status), seen};
}

TEST_F(Command, tells_people_at_a_terminal_what_is_wrong_where_what_is_allowed_and_what_was_meant) {
  struct Case {
    std::string arguments;
    int exit_code;
    std::vector<std::string> lines;
  };
  const std::string cloud = sphere();
  const std::string here = folder_.string();
  const std::vector<Case> cases{
      {"reconstrct x", 2, {"what      'reconstrct' is no command", "Did you mean 'reconstruct'?"}},
      {"", 2, {"no command is given", "allowed   one of reconstruct"}},
      {"reconstruct " + cloud, 2, {"where     -o", "surfaced reconstruct CLOUD -o MESH"}},
      {"reconstruct " + cloud + " -o m.glb --metod x", 2, {"where     --metod", "Did you mean '--method'?"}},
      {"reconstruct " + cloud + " -o m.glb --threads 0", 2, {"where     --threads", "value     0", "1 - 1024"}},
      {"reconstruct " + cloud + " -o m.glb --output clud", 2, {"value     clud", "Did you mean 'cloud'?"}},
      {"reconstruct " + cloud + " -o m.glb --method local-delauny",
       2,
       {"where     method", "value     local-delauny", "Did you mean 'local-delaunay'?",
        "code      unknown_method, exit 2"}},
      {"reconstruct " + cloud + " -o m.glb --param varant=best", 2, {"where     varant", "Did you mean 'variant'?"}},
      {"reconstruct " + cloud + " -o m.glb --param variant=bset", 2, {"value     \"bset\"", "Did you mean 'best'?"}},
      {"reconstruct " + cloud + " -o " + here + "/no/m.glb", 2, {"where     -o", "mkdir -p"}},
      {"reconstruct " + here + "/spere.ply -o m.glb", 3, {"where     CLOUD", "Did you mean 'sphere.ply'?"}},
      {"measure " + here + "/spere.ply", 3, {"where     MESH", "Did you mean 'sphere.ply'?"}},
      {"serve --data " + here + "/d --memory 2GB", 2, {"where     --memory", "Did you mean '--job-memory'?"}},
      {"serve --data " + here + "/d --ttl 1y",
       2,
       {"where     ttl", "value     1y", "allowed   1 s to 365 d", "1.5 h, 1 d"}},
      {"serve", 2, {"where     data", "--data ./surfaced-data"}},
      {"check-config --log-format jsn --data " + here, 2, {"where     log-format", "Did you mean 'json'?"}},
      {"methods --jsn", 2, {"where     --jsn", "Did you mean '--json'?"}},
      {"keys lst", 2, {"'lst' is no command", "Did you mean 'list'?"}},
      {"keys add k.json --name n --stored-bytes 5x", 2, {"where     --stored-bytes", "1.5 GB"}},
      {"backup " + here, 2, {"where     --data"}},
      {"backup " + here + " --data " + here, 2, {"where     TARGET", "lies in the folder that is to be copied"}},
  };
  for (const Case& each : cases) {
    const auto [code, seen] = at_a_terminal(folder_, each.arguments);
    EXPECT_EQ(code, each.exit_code) << each.arguments << "\n" << seen;
    for (const std::string& line : each.lines) EXPECT_THAT(seen, HasSubstr(line)) << each.arguments;
    EXPECT_THAT(seen, HasSubstr("hint      ")) << each.arguments;
    EXPECT_THAT(seen, ::testing::Not(HasSubstr("{\"code\""))) << each.arguments;
  }
}

TEST_F(Command, errors_are_json_with_the_same_parts_where_asked_or_where_no_terminal_is) {
  for (const char* const arguments :
       {"reconstruct --json c.ply -o m.glb --method magik", "methods --json --flat", "keys list k.json --json"}) {
    const auto [code, seen] = at_a_terminal(folder_, arguments);
    EXPECT_NE(code, 0) << arguments;
    EXPECT_TRUE(nlohmann::json::accept(seen)) << arguments << "\n" << seen;
  }
  const auto told = problem(run({"reconstruct", sphere(), "-o", folder_ / "m.glb", "--method", "poison"}));
  EXPECT_EQ(told.at("field"), "method");
  EXPECT_EQ(told.at("value"), "poison");
  EXPECT_THAT(told.at("allowed").get<std::string>(), HasSubstr("poisson"));
  EXPECT_THAT(told.at("hint").get<std::string>(), HasSubstr("Did you mean 'poisson'?"));
  EXPECT_THAT(told.at("hint").get<std::string>(), ::testing::Not(HasSubstr("GET /")));
}

TEST_F(Command, what_a_file_or_an_argument_says_cannot_write_elsewhere_on_a_terminal) {
  const auto seen = at_a_terminal(folder_, "reconstruct x.ply -o m.glb --method \"$(printf \"\\033[2J\")\"").second;
  EXPECT_EQ(seen.find('\x1b'), std::string::npos) << seen;
}

TEST_F(Command, writes_the_points_of_a_method_that_makes_some_upsampled_and_completed) {
  std::vector<Point3> open = testing::sphere_points(4000);
  std::erase_if(open, [](const Point3& p) { return p[2] > 0.8; });
  const auto bytes = encode_cloud_ply(open, {}, {});
  const fs::path cloud = write("open.ply", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const auto points_with = [&](std::vector<std::string> parameters) {
    std::vector<std::string> command{"reconstruct", cloud,
                                     "-o",          folder_ / "points.ply",
                                     "--output",    "cloud",
                                     "--method",    "intrinsic-delaunay",
                                     "--report",    folder_ / "r.json"};
    for (const std::string& each : parameters) command.insert(command.end(), {"--param", each});
    const Ran ran = run(command);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    const auto report = nlohmann::json::parse(read_all(folder_ / "r.json"));
    EXPECT_TRUE(report.at("encoding").is_null());
    const auto points = read_cloud(folder_ / "points.ply");
    EXPECT_TRUE(points.ok());
    return std::pair(points ? points->size() : 0, report);
  };
  EXPECT_EQ(points_with({"fill_holes=none"}).first, open.size());
  const auto [filled, report] = points_with({"fill_holes=all"});
  EXPECT_EQ(report.at("mesh").at("closed"), true);
  EXPECT_EQ(filled, open.size() + report.at("hole_filling").at("vertices_added").get<std::size_t>());
  const auto [denser, upsampled] = points_with({"fill_holes=none", "upsample=jet", "epsilon=0.03"});
  const auto added = upsampled.at("method_statistics").at("upsampling").at("points_added").get<std::size_t>();
  EXPECT_GT(added, 500U);
  EXPECT_EQ(denser, open.size() + added);
}

TEST_F(Command, mesh_does_not_depend_on_the_number_of_threads) {
  const fs::path cloud = sphere(3000);
  ASSERT_EQ(run({"reconstruct", cloud, "-o", folder_ / "a.glb", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(run({"reconstruct", cloud, "-o", folder_ / "b.glb", "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(read_all(folder_ / "a.glb"), read_all(folder_ / "b.glb"));
}

TEST_F(Command, wrong_use_is_exit_code_2_with_a_problem) {
  const std::string cloud = sphere();
  const std::string mesh = folder_ / "m.glb";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "invalid_usage"},
      {{"fly"}, "invalid_usage"},
      {{"reconstruct", cloud}, "invalid_usage"},
      {{"reconstruct", cloud, "-o", mesh, "--threads", "0"}, "invalid_usage"},
      {{"reconstruct", cloud, "-o", mesh, "--param", "beta"}, "invalid_usage"},
      {{"reconstruct", cloud, "-o", mesh, "--output", "cloud"}, "unknown_output"},
      {{"reconstruct", cloud, "-o", mesh, "--output", "cloud", "--method", "intrinsic-delaunay"}, "unknown_output"},
      {{"reconstruct", cloud, "-o", mesh, "--method", "magic"}, "unknown_method"},
      {{"reconstruct", cloud, "-o", mesh, "--param", "gamma=1"}, "unknown_parameter"},
      {{"reconstruct", cloud, "-o", mesh, "--param", "variant=slow"}, "invalid_parameter"},
      {{"reconstruct", cloud, "-o", folder_ / "m.xyz"}, "unknown_output"},
      {{"reconstruct", cloud, "-o", folder_ / "no" / "such" / "m.glb"}, "output_not_writable"},
  };
  for (const auto& [arguments, code] : cases) {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.exit_code, 2) << code << ran.err;
    EXPECT_EQ(problem(ran).at("code"), code) << ran.err;
  }
}

TEST_F(Command, a_word_that_is_no_command_is_named_with_those_there_are_and_a_hint) {
  const Ran ran = run({"reconstrct", sphere()});
  EXPECT_EQ(ran.exit_code, 2);
  const std::string detail = problem(ran).at("detail");
  EXPECT_NE(detail.find("'reconstrct' is no command"), std::string::npos) << detail;
  EXPECT_NE(detail.find("reconstruct, measure"), std::string::npos) << detail;
  EXPECT_EQ(detail.find("attempt"), std::string::npos) << "what the server starts is not for people: " << detail;
  EXPECT_NE(problem(ran).at("hint"), "");
}

TEST_F(Command, methods_are_listed_with_ranges_and_what_all_share_once) {
  const std::string text = run({"methods"}).out;
  EXPECT_NE(text.find("variant=best  (best, fast, paper)"), std::string::npos) << text;
  EXPECT_NE(text.find("simplify=none  (none, whole, from 4 to 4294967295, above 0 to 0.5"), std::string::npos) << text;
  EXPECT_EQ(text.find("simplify="), text.rfind("simplify="));
}

TEST_F(Command, environment_variables_stand_in_for_flags) {
  ::setenv("SURFACED_METHOD", "magic", 1);
  const Ran ran = run({"reconstruct", sphere(), "-o", folder_ / "m.glb"});
  ::unsetenv("SURFACED_METHOD");
  EXPECT_EQ(problem(ran).at("code"), "unknown_method");
}

TEST_F(Command, an_input_that_is_not_there_is_exit_code_3) {
  const Ran ran = reconstruct(folder_ / "nothing.ply");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_EQ(problem(ran).at("code"), "input_unreadable");
}

/// Bytes that are no usable cloud, and the code that each must give.
std::vector<std::tuple<std::string, std::string, std::vector<std::string>>> bad_inputs() {
  const std::string le = "binary_little_endian";
  std::string collinear;
  std::string many_equal;
  for (int i = 0; i < 20000; ++i) {
    collinear += std::to_string(i) + " " + std::to_string(2 * i) + " 0\n";
    many_equal += "1 2 3\n";
  }
  const std::string png = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) + std::string(1000, 'x');
  return {
      {"empty", "", {"empty_input"}},
      {"text", "the quick brown fox\n", {"unknown_format"}},
      {"zeros", std::string(1 << 20, '\0'), {"unknown_format"}},
      {"png named ply", png, {"unknown_format"}},
      {"no header end", "ply\nformat ascii 1.0\n", {"truncated_input", "malformed_input"}},
      {"endless header", "ply\n" + std::string(1 << 20, 'a'), {"malformed_input", "truncated_input"}},
      {"binary truncated", ply(le, "1000", "float", std::string(6000, '\0')), {"truncated_input"}},
      {"2^40 points",
       ply(le, "1099511627776", "float", std::string(100, '\0')),
       {"truncated_input", "too_many_points"}},
      {"2^40 ascii points", ply("ascii", "1099511627776", "float", "0 0 0\n"), {"truncated_input", "too_many_points"}},
      {"negative count", ply("ascii", "-5", "float", "0 0 0\n"), {"malformed_input"}},
      {"count beyond 64 bits", ply("ascii", "99999999999999999999999", "float", ""), {"truncated_input"}},
      {"no points", ply("ascii", "0", "float", ""), {"empty_input"}},
      {"NaN", ply("ascii", "2", "float", "0 0 nan\nnan 0 0\n"), {"coordinate_not_finite"}},
      {"Inf", ply("ascii", "2", "double", "0 0 -inf\n0 inf 0\n"), {"coordinate_not_finite"}},
      {"1e299", ply("ascii", "1", "double", "1e299 0 0\n"), {"coordinate_out_of_range"}},
      {"equal points", ply("ascii", "20000", "float", many_equal), {"too_few_points"}},
      {"two points", ply("ascii", "2", "float", "0 0 0\n1 1 1\n"), {"too_few_points"}},
      {"collinear", ply("ascii", "20000", "float", collinear), {"collinear"}},
      {"no z",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
       {"missing_positions"}},
      {"letters for numbers", ply("ascii", "2", "float", "a b c\nd e f\n"), {"malformed_input"}},
      {"draco of 61 bytes",
       std::string("DRACO\x02\x02\0\0\0\0", 11) + std::string(50, '\x7f'),
       {"malformed_input", "truncated_input", "unsupported_feature", "missing_positions"}},
      {"draco cut", std::string("DRACO\x02\x02\0\0", 9), {"malformed_input", "truncated_input", "unsupported_feature"}},
  };
}

TEST_F(Command, bad_input_ends_with_its_code_exit_3_within_2_seconds_and_200_megabytes) {
  for (const auto& [name, bytes, codes] : bad_inputs()) {
    const Ran ran = reconstruct(write("bad.ply", bytes));
    EXPECT_EQ(ran.exit_code, 3) << name << ": " << ran.err;
    ASSERT_TRUE(nlohmann::json::accept(ran.err)) << name << ": " << ran.err;
    EXPECT_THAT(codes, ::testing::Contains(problem(ran).at("code").get<std::string>())) << name << ": " << ran.err;
    EXPECT_LT(ran.seconds, 2.0) << name;
    EXPECT_LT(ran.peak_megabytes, 200.0) << name;
    EXPECT_FALSE(fs::exists(folder_ / "m.glb")) << name;
  }
}

TEST_F(Command, coplanar_points_are_refused_by_the_method_that_needs_a_volume) {
  std::vector<Point3> points = testing::random_points(100, 5);
  for (Point3& p : points) p[2] = 0.5;
  const auto bytes = encode_cloud_ply(points, {}, {});
  const fs::path cloud = write("flat.ply", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const Ran refused = run({"reconstruct", cloud, "-o", folder_ / "m.glb", "--method", "minimum-boundary"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_EQ(problem(refused).at("code"), "coplanar");
  EXPECT_EQ(reconstruct(cloud).exit_code, 0);
}

TEST_F(Command, a_normal_that_is_not_finite_is_dropped_with_a_warning) {
  std::string body;
  for (const Point3& p : testing::sphere_points(100)) {
    for (const double x : p) body += std::to_string(x) + " ";
    body += "nan 0 1\n";
  }
  const fs::path cloud =
      write("normals.ply",
            "ply\nformat ascii 1.0\nelement vertex 100\nproperty float x\nproperty float y\nproperty float "
            "z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n" +
                body);
  const Ran ran = run({"reconstruct", cloud, "-o", folder_ / "m.glb", "--report", "-"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(nlohmann::json::parse(ran.out).at("warnings").dump(), HasSubstr("normals dropped"));
}

TEST_F(Command, every_shared_cloud_gives_a_mesh_whose_report_agrees_with_a_recount) {
  if (!fs::exists(SURFACED_SHARED_DATA)) GTEST_SKIP() << "./dev data fetches its clouds";
  for (const auto& entry : fs::directory_iterator(SURFACED_SHARED_DATA)) {
    const std::string extension = entry.path().extension();
    if (extension != ".ply" && extension != ".drc") continue;
    const Ran ran =
        run({"reconstruct", entry.path(), "-o", folder_ / "m.glb", "--method", "advancing-front", "--report", "-"});
    ASSERT_EQ(ran.exit_code, 0) << entry.path() << ran.err;
    const auto report = nlohmann::json::parse(ran.out);
    const Ran recount = run({"measure", folder_ / "m.glb", "--cloud", entry.path()});
    ASSERT_EQ(recount.exit_code, 0) << entry.path() << recount.err;
    const auto measured = nlohmann::json::parse(recount.out);
    EXPECT_EQ(measured.at("mesh"), report.at("mesh")) << entry.path();
    EXPECT_EQ(measured.at("quality").at("unused_points"), report.at("quality").at("unused_points")) << entry.path();
    EXPECT_TRUE(report.at("mesh").at("edge_manifold").get<bool>()) << entry.path();
  }
}

}  // namespace
}  // namespace surfaced
