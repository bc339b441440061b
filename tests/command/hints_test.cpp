// SPDX-License-Identifier: GPL-3.0-or-later
// What hints, refusals and warnings tell to do works when it is tried.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "command/command_run.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using testing::Command;
using ::testing::HasSubstr;
using testing::Ran;
using testing::read_all;
namespace fs = std::filesystem;

/// The commands of ours that a text names: `surfaced`, then small words and flags.
std::vector<std::vector<std::string>> commands_in(const std::string& text) {
  std::vector<std::vector<std::string>> commands;
  static const std::regex kCommand("surfaced((?: --?[a-z-]+| [a-z]+(?=[,;. ]|$))+)");
  for (std::sregex_iterator found(text.begin(), text.end(), kCommand), end; found != end; ++found) {
    std::istringstream words((*found)[1].str());
    std::vector<std::string> command;
    for (std::string word; words >> word && command.size() < 2 && word != "lists" && word != "gives";) {
      command.push_back(word);
    }
    if (!command.empty()) commands.push_back(command);
  }
  return commands;
}

TEST_F(Command, every_command_that_a_hint_names_runs) {
  const auto table = nlohmann::json::parse(std::ifstream(SURFACED_ERRORS));
  std::size_t run_ones = 0;
  for (const auto& row : table.at("errors")) {
    for (std::vector<std::string> command : commands_in(row.at("hint").get<std::string>())) {
      if (command.front() != "--help" && command != std::vector<std::string>{"methods"}) command.emplace_back("--help");
      const Ran ran = run(command);
      EXPECT_EQ(ran.exit_code, 0) << row.at("hint") << ran.err;
      ++run_ones;
    }
  }
  EXPECT_GE(run_ones, 3U);
}

/// A file, how it is read, and the parameter that what is said of it names as the way out.
struct Way {
  std::string file;
  std::string text;
  std::string given;
  std::string way;
};

std::string sphere_rows(const std::string& more = {}) {
  std::string rows;
  for (const Point3& p : testing::sphere_points(500)) {
    rows += std::to_string(p[0]) + "," + std::to_string(p[1]) + "," + std::to_string(p[2]) + more + "\n";
  }
  return rows;
}

/// Rows whose commas may be anything.
std::string comma_rows() {
  std::string rows;
  for (const Point3& p : testing::sphere_points(500)) {
    rows += std::to_string(90 * p[0]) + "," + std::to_string(80 * p[1]) + "," + std::to_string(70 * p[2]) + "\n";
  }
  std::ranges::replace(rows, '.', ',');
  return rows;
}

std::string five_scans() {
  std::string rows;
  for (int scan = 0; scan < 5; ++scan) {
    for (const Point3& p : testing::sphere_points(500)) {
      for (const double x : p) rows += std::to_string(x + scan * 1e-6) + " ";
      rows += "\n";
    }
  }
  return rows;
}

std::string sphere_obj() {
  std::string text;
  for (const Point3& p : testing::sphere_points(500)) {
    text += "v " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  }
  return text + "f 1 2 3\nf 1 3 2\n";
}

std::string splats() {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 500\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "rot_0"}) {
    text += std::string("property float ") + name + "\n";
  }
  std::string rows = sphere_rows(",0,0,0,1,-4,1");
  std::ranges::replace(rows, ',', ' ');
  return text + "end_header\n" + rows;
}

std::vector<Way> ways() {
  const std::string rows = sphere_rows();
  return {{"names.csv", "a,b,c\n" + rows, "", "columns=x,y,z"},
          {"degrees.csv", "lon,lat,height\n" + rows, "", "columns=x,y,z"},
          {"more.csv", rows, "columns=x,y,z,nx,ny,nz", "columns=x,y,z"},
          {"commas.csv", comma_rows(), "", "separator=comma"},
          {"cut.pts", "600\n" + rows, "", "truncated=take"},
          {"nothing.csv", "nan,nan,nan\n" + rows, "missing=refuse", "missing=drop"},
          {"zeros.csv",
           [&] {
             std::string zeros = rows;
             for (int i = 0; i < 50; ++i) zeros += "0,0,0\n";
             return zeros;
           }(),
           "", "missing=refuse"},
          {"codes.csv", sphere_rows(",7,TREE"), "", "columns=x,y,z,-,-"},
          {"scans.xyz", five_scans(), "", "fuse=auto"},
          {"mesh.obj", sphere_obj(), "", "input=mesh"},
          {"points.xyz", rows, "input=mesh", "input=cloud"},
          {"splats.ply", splats(), "", "splat_opacity=0.5"}};
}

/// What a refusal or a warning says helps.
TEST_F(Command, every_way_out_that_a_message_names_works) {
  for (const Way& way : ways()) {
    std::vector<std::string> arguments{"reconstruct", write(way.file, way.text), "-o",       folder_ / "m.glb",
                                       "--method",    "advancing-front",         "--report", folder_ / "report.json",
                                       "--param"};
    std::vector<std::string> first = arguments;
    if (way.given.empty()) {
      first.pop_back();
    } else {
      first.push_back(way.given);
    }
    fs::remove(folder_ / "report.json");
    const Ran said = run(first);
    EXPECT_THAT(said.err + read_all(folder_ / "report.json"), HasSubstr(way.way)) << way.file;
    arguments.push_back(way.way);
    const Ran taken = run(arguments);
    EXPECT_EQ(taken.exit_code, 0) << way.file << taken.err;
  }
}

}  // namespace
}  // namespace surfaced
