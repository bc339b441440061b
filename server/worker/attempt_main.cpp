// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_main.hpp"

#include <iostream>
#include <new>

#include "io/io.hpp"
#include "platform/files.hpp"
#include "reconstruction/reconstruction.hpp"
#include "worker/attempt_budget.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confined_work.hpp"

namespace surfaced {
namespace {

void log_report(const Json& report) {
  if (const auto warnings = report.find("warnings"); warnings != report.end()) {
    for (const Json& warning : *warnings) std::cerr << "warning " << warning.dump() << "\n";
  }
  if (const auto stages = report.find("stages"); stages != report.end()) {
    for (const Json& stage : *stages) {
      std::cerr << "stage " << stage.value("name", "?") << " " << stage.value("seconds", 0.0) << " s\n";
    }
  }
  for (const char* const part : {"cloud", "mesh", "resources"}) {
    if (const auto found = report.find(part); found != report.end()) std::cerr << part << " " << found->dump() << "\n";
  }
}

Status reconstruct_within(AttemptBudget& budget, const AttemptSpec& spec) {
  const auto method = find_method(spec.method);
  if (!method) return method.error();
  auto parameters = check_parameters(**method, spec.parameters);
  if (!parameters) return std::move(parameters).error();
  FileRequest request{.cloud = spec.cloud,
                      .mesh = spec.directory / spec.mesh,
                      .method = *method,
                      .parameters = std::move(*parameters),
                      .limits = ReadLimits{spec.limits.max_points},
                      .cloud_name = "the cloud",
                      .cloud_sha256 = spec.cloud_sha256,
                      .points = spec.points.empty() ? std::filesystem::path() : spec.directory / spec.points,
                      .kept = spec.directory / kKeptMesh};
  request.on_read = [&](std::size_t points) {
    return budget.begin(std::to_string(points) + " points with " + spec.method, most_cost(**method, points));
  };
  for (const std::string& name : spec.more_meshes) request.more_meshes.push_back(spec.directory / name);
  Context context(spec.limits.threads, [](double fraction, std::string_view stage) {
    tell_server(encode(ProgressMessage{fraction, std::string(stage)}));
  });
  const Result<Json> report = reconstruct_file(request, context);
  if (!report) return report.error();
  log_report(*report);
  return write_file(spec.directory / "report.json", as_bytes(report->dump(2) + "\n"));
}

Status reconstruct(const AttemptSpec& spec) {
  AttemptBudget budget(spec.limits);
  try {
    return reconstruct_within(budget, spec);
  } catch (const std::bad_alloc&) {
    return budget.out_of_memory();
  }
}

}  // namespace

int attempt_main(const std::string& description) { return run_confined(description, reconstruct); }

}  // namespace surfaced
