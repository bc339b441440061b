#include "worker/attempt_main.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>

#include "io/io.hpp"
#include "platform/files.hpp"
#include "reconstruction/reconstruction.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confinement.hpp"
#include "worker/convert.hpp"

namespace surfaced {
namespace {

void send(const std::string& message) {
  // Nobody to tell if this fails: then the server is gone, and its death is this process's.
  [[maybe_unused]] const Status ignored = write_all(kMessageDescriptor, as_bytes(message), "tell the server");
}

int give_up(const Error& error) {
  std::cerr << "problem " << name_of(error.code) << ": " << error.detail << std::endl;
  send(encode(error));
  return exit_code_of(error.code);
}

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

Status reconstruct(const AttemptSpec& spec) {
  const auto method = find_method(spec.method);
  if (!method) return method.error();
  auto parameters = check_parameters(**method, spec.parameters);
  if (!parameters) return std::move(parameters).error();
  const FileRequest request{spec.cloud,
                            spec.directory / spec.mesh,
                            *method,
                            std::move(*parameters),
                            ReadLimits{spec.limits.max_points},
                            "the cloud",
                            spec.points.empty() ? std::filesystem::path() : spec.directory / spec.points};
  Context context(spec.limits.threads, [](double fraction, std::string_view stage) {
    send(encode(ProgressMessage{fraction, std::string(stage)}));
  });
  const Result<Json> report = reconstruct_file(request, context);
  if (!report) return report.error();
  log_report(*report);
  for (const std::string& name : spec.more_meshes) {
    const Status converted =
        convert_mesh(spec.directory / spec.mesh, spec.directory / name, request.parameters, *report);
    if (!converted) return converted;
  }
  return write_file(spec.directory / "report.json", as_bytes(report->dump(2) + "\n"));
}

}  // namespace

int attempt_main(const std::string& description) {
  const auto spec = decode_attempt(description);
  if (!spec) {
    std::cerr << spec.error().detail << "\n";
    return exit_code_of(spec.error().code);
  }
  try {
    const auto confined = confine_this_process(*spec);
    if (!confined) return give_up(confined.error());
    std::cerr << "confined by " << *confined << std::endl;
    const Status done = reconstruct(*spec);
    return done ? 0 : give_up(done.error());
  } catch (const std::bad_alloc&) {
    return give_up({ErrorCode::out_of_memory,
                    "an allocation failed; the limit is " + std::to_string(spec->limits.memory_bytes) + " bytes"});
  } catch (const std::exception& failure) {
    return give_up({ErrorCode::internal_error, failure.what()});
  }
}

}  // namespace surfaced
