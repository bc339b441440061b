// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <memory>
#include <thread>

#include "command/command.hpp"
#include "command/problem.hpp"
#include "command/progress_bar.hpp"
#include "command/usage.hpp"
#include "command/write_report.hpp"

namespace surfaced {
namespace {

struct MeasureOptions {
  std::string mesh;
  std::string cloud;
  std::string report = "-";
  bool self_intersections = false;
};

int measure(const MeasureOptions& options) {
  Context context(std::max(1U, std::thread::hardware_concurrency()), progress_bar());
  const std::optional<std::filesystem::path> cloud =
      options.cloud.empty() ? std::nullopt : std::optional<std::filesystem::path>(options.cloud);
  const Result<Json> report = measure_file(options.mesh, cloud, options.self_intersections, context);
  clear_progress_bar();
  if (!report) {
    const std::array inputs{GivenPath{"MESH", options.mesh}, GivenPath{"--cloud", options.cloud}};
    return report_file_problem(report.error(), inputs, {});
  }
  return write_report(*report, options.report);
}

}  // namespace

void add_measure(CLI::App& app, Run& run) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App* command = app.add_subcommand("measure", "Measure the quality of any mesh");
  command->add_option("MESH", options->mesh, "Mesh: GLB, glTF, Draco, PLY, OBJ, STL or 3MF, told by content")
      ->required();
  command->add_option("--cloud", options->cloud, "Cloud to count unused and interior points of")
      ->envname("SURFACED_CLOUD");
  command->add_option("--report", options->report, "Where to write the report; - for standard output")
      ->type_name("FILE|-")
      ->capture_default_str()
      ->envname("SURFACED_REPORT");
  command->add_flag("--self-intersections", options->self_intersections, "Count intersecting pairs of triangles (slow)")
      ->envname("SURFACED_SELF_INTERSECTIONS");
  command->callback([options, &run] { run = [options] { return measure(*options); }; });
}

}  // namespace surfaced
