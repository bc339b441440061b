// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <iostream>
#include <memory>
#include <thread>

#include "command/command.hpp"
#include "command/problem.hpp"
#include "command/progress_bar.hpp"
#include "command/usage.hpp"
#include "command/write_report.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

struct Options {
  std::string cloud;
  std::string mesh;
  std::string method{methods().front().id};
  std::vector<std::string> parameters;
  std::string output = "mesh";
  std::string report;
  unsigned threads = 0;
};

// Set by the first Ctrl-C; the second one ends the process as usual.
std::atomic<bool> interrupted = false;

extern "C" void interrupt(int signal) {
  interrupted = true;
  std::signal(signal, SIG_DFL);
}

Result<std::vector<std::pair<std::string, std::string>>> split_parameters(const std::vector<std::string>& given) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& each : given) {
    const std::size_t equals = each.find('=');
    if (equals == std::string::npos || equals == 0) {
      return with_fault({ErrorCode::invalid_usage, "--param " + each + ": expected name=value"},
                        {"--param", each, "name=value, like variant=fast"});
    }
    pairs.emplace_back(each.substr(0, equals), each.substr(equals + 1));
  }
  return pairs;
}

Result<FileRequest> request_of(const Options& options) {
  const Result<const MethodInfo*> method = find_method(options.method);
  if (!method) return method.error();
  const auto given = split_parameters(options.parameters);
  if (!given) return given.error();
  Result<Json> parameters = parameters_from_text(**method, *given);
  if (!parameters) return std::move(parameters).error();
  FileRequest request{
      .cloud = options.cloud, .method = *method, .parameters = std::move(*parameters), .files_beside = true};
  if (options.output == "cloud") {
    if (Status made = check_makes_cloud(**method); !made) return std::move(made).error();
    if (std::filesystem::path(options.mesh).extension() != ".ply") {
      return Error{ErrorCode::unknown_output, "-o " + options.mesh + ": a cloud is written as .ply"};
    }
    request.points = options.mesh;
    return request;
  }
  if (const auto format = mesh_format_of(options.mesh); !format) return format.error();
  request.mesh = options.mesh;
  return request;
}

/// For people at a terminal; a program reads the report.
void tell_result(const Json& report, const Options& options) {
  if (isatty(STDERR_FILENO) == 0) return;
  const Json& mesh = report.at("mesh");
  const bool closed = mesh.at("closed") == true;
  if (options.output == "mesh") {
    std::cerr << options.mesh << ": " << mesh.at("vertices") << " vertices, " << mesh.at("triangles") << " triangles, "
              << (closed ? "closed" : "open");
    if (closed && mesh.at("genus").is_number()) std::cerr << ", genus " << mesh.at("genus");
    std::cerr << "\n";
  }
  for (const Json& warning : report.at("warnings")) std::cerr << "warning: " << warning.get<std::string>() << "\n";
}

int reconstruct(const Options& options) {
  Result<FileRequest> request = request_of(options);
  if (!request) return report_problem(request.error());
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  const unsigned threads = options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency());
  Context context(threads, progress_bar(), &interrupted);
  const Result<Json> report = reconstruct_file(*request, context);
  clear_progress_bar();
  if (!report) {
    return report_file_problem(report.error(), std::array{GivenPath{"CLOUD", options.cloud}}, {"-o", options.mesh});
  }
  tell_result(*report, options);
  return write_report(*report, options.report);
}

}  // namespace

void add_reconstruct(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("reconstruct", "Turn a point cloud into a mesh");
  command
      ->add_option(
          "CLOUD", options->cloud,
          "Point cloud: PLY, Draco, LAS, PCD, glTF, OBJ, STL, 3MF or text, told by content, also in gzip or ZIP")
      ->required();
  command->add_option("-o", options->mesh, "Mesh to write: .glb, .gltf, .drc, .ply, .obj, .stl or .3mf")
      ->required()
      ->type_name("MESH");
  command->add_option("--method", options->method, "Method, see: surfaced methods")
      ->capture_default_str()
      ->envname("SURFACED_METHOD");
  command->add_option("--param", options->parameters, "Parameter of the method, may be repeated")
      ->type_name("name=value")
      ->allow_extra_args(false);
  command
      ->add_option("--output", options->output,
                   "What to write: mesh, or cloud: the points, upsampled and completed (intrinsic-delaunay)")
      ->check(CLI::IsMember({"mesh", "cloud"}))
      ->capture_default_str()
      ->envname("SURFACED_OUTPUT");
  command->add_option("--report", options->report, "Where to write the report; - for standard output")
      ->type_name("FILE|-")
      ->envname("SURFACED_REPORT");
  command->add_option("--threads", options->threads, "Threads to use; default: all cores")
      ->check(CLI::Range(1U, 1024U))
      ->envname("SURFACED_THREADS");
  command->callback([options, &run] { run = [options] { return reconstruct(*options); }; });
}

}  // namespace surfaced
