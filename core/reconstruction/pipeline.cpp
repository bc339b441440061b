// SPDX-License-Identifier: GPL-3.0-or-later
// The way of a cloud: read -> method -> orient -> finish -> deliver (delivery.hpp).
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "base/cancelled.hpp"
#include "base/library_failure.hpp"
#include "reconstruction/delivery.hpp"
#include "reconstruction/finishing_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/orienting_stage.hpp"
#include "reconstruction/preparing_stage.hpp"
#include "reconstruction/provenance.hpp"
#include "reconstruction/reading_stage.hpp"
#include "reconstruction/report.hpp"

namespace surfaced {
namespace {

// Shares of the progress bar.
constexpr double kReadUntil = 0.1;
constexpr double kPreparedUntil = 0.3;
constexpr double kMethodUntil = 0.7;
constexpr double kFinishedUntil = 0.9;

double seconds_of(const std::vector<Stage>& stages) {
  double sum = 0;
  for (const Stage& stage : stages) sum += stage.seconds;
  return sum;
}

void add_run(Json& report, Context& context) {
  const std::vector<Stage> stages = context.finish();
  const Resources resources = resources_used();
  report["stages"] = stages_json(stages);
  report["resources"] = Json{{"wall_seconds", seconds_of(stages)},
                             {"cpu_seconds", resources.cpu_seconds},
                             {"peak_rss_bytes", resources.peak_rss_bytes},
                             {"threads", context.threads()}};
}

/// What the method makes: all points as vertices, used or not.
Result<Reconstruction> engine_of(const PointCloud& cloud, const MethodInfo& method, const Json& parameters,
                                 Context& context) {
  Result<Reconstruction> result = method_of(method).engine(cloud, parameters, context);
  if (result && result->mesh.triangles.empty()) {
    return Error{ErrorCode::method_failed,
                 "method '" + method.id + "' made no triangle of " + std::to_string(cloud.size()) + " distinct points"};
  }
  return result;
}

/// The stages before the method, where the parameters ask for them, and the method.
struct Made {
  Reconstruction result;
  Json preparing = Json::array();
};

/// Mesh files hold float32: of points that differ by less than its least number nothing would be left, and squares of
/// their distances are too small for a double.
Status check_extent(const PointCloud& cloud) {
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<float>::min());
  const Bounds bounds = bounds_of(cloud.positions);
  const double extent = std::ranges::max(bounds.high - bounds.low);
  if (cloud.size() < 2 || extent >= kLeast) return Done{};
  return Error{ErrorCode::coordinate_out_of_range,
               "the " + std::to_string(cloud.size()) + " distinct points are within " + Json(extent).dump() +
                   " of each other, less than the least float32, " + Json(kLeast).dump()};
}

/// What preparing warns of, beyond what the cloud did before, stands before the method's warnings.
Result<Made> make(const PointCloud& cloud, const MethodInfo& method, const Json& parameters, double until,
                  Context& context) {
  if (Status fits = check_extent(cloud); !fits) return std::move(fits).error();
  if (!asks_for_preparing(parameters)) {
    context.section(until);
    Result<Reconstruction> result = engine_of(cloud, method, parameters, context);
    if (!result) return std::move(result).error();
    return Made{.result = std::move(*result)};
  }
  context.section(kPreparedUntil);
  Result<Prepared> prepared = prepare(cloud, parameters, context);
  if (!prepared) return std::move(prepared).error();
  context.section(until);
  Result<Reconstruction> result = engine_of(prepared->cloud, method, parameters, context);
  if (!result) return std::move(result).error();
  const std::vector<std::string>& warnings = prepared->cloud.warnings;
  const auto known = static_cast<std::ptrdiff_t>(std::min(cloud.warnings.size(), warnings.size()));
  result->warnings.insert(result->warnings.begin(), warnings.begin() + known, warnings.end());
  return Made{.result = std::move(*result), .preparing = std::move(prepared->stages)};
}

/// What there is to finish: of a cloud, what the method makes of it; of a mesh, the mesh.
struct Input {
  PointCloud cloud;
  Made made;
};

Status tell_points(const FileRequest& request, std::size_t points) {
  return request.on_read ? request.on_read(points) : Status(Done{});
}

Result<Input> mesh_input(const FileRequest& request, const ReadOptions& options, Context& context) {
  Result<LoadedMesh> loaded = load_mesh(request.cloud, options, request.cloud_name, context);
  if (!loaded) return std::move(loaded).error();
  if (Status taken = tell_points(request, loaded->cloud.size()); !taken) return std::move(taken).error();
  context.section(kFinishedUntil);
  Input input{.cloud = std::move(loaded->cloud), .made = {}};
  input.made.result.mesh = std::move(loaded->mesh);
  input.made.result.warnings.emplace_back("input=mesh: the faces of the file are kept, no method has run");
  return input;
}

double method_until(const Json& parameters) { return asks_for_simplifying(parameters) ? kMethodUntil : kFinishedUntil; }

/// A method that fails fails of what is doubtful first.
Error with_doubts(Error error, const std::vector<std::string>& doubts) {
  if (error.code != ErrorCode::method_failed) return error;
  for (const std::string& doubt : doubts) error.detail += "; " + doubt;
  return error;
}

Result<Input> input_of(const FileRequest& request, Context& context) {
  context.section(kReadUntil);
  context.enter("read", 1);
  const ReadOptions options = read_options_of(request.parameters, request.limits, request.files_beside);
  if (asks_for_mesh(request.parameters)) return mesh_input(request, options, context);
  const Missing missing = request.parameters.at("missing") == "refuse" ? Missing::refuse : Missing::drop;
  Result<PointCloud> cloud = load_cloud(request.cloud, options, missing, request.cloud_name, context);
  if (!cloud) return std::move(cloud).error();
  if (Status taken = tell_points(request, cloud->size()); !taken) return std::move(taken).error();
  const std::vector<std::string> doubts = doubts_of(*cloud, request.parameters, context);
  cloud->warnings.insert(cloud->warnings.end(), doubts.begin(), doubts.end());
  Result<Made> made = make(*cloud, *request.method, request.parameters, method_until(request.parameters), context);
  if (!made) return with_doubts(std::move(made).error(), doubts);
  return Input{std::move(*cloud), std::move(*made)};
}

Result<Reconstruction> run_unguarded(const PointCloud& cloud, const MethodInfo& method, const Json& parameters,
                                     Context& context) {
  Result<Made> made = make(cloud, method, parameters, asks_for_simplifying(parameters) ? kMethodUntil : 1, context);
  if (!made) return std::move(made).error();
  context.section(1);
  orient(made->result, parameters, cloud.source.viewpoint);
  if (Status finished = finish(made->result, parameters, context); !finished) return std::move(finished).error();
  return std::move(made->result);
}

Result<Json> reconstruct_unguarded(const FileRequest& request, Context& context) {
  std::optional<MeshFormat> format;
  if (!request.mesh.empty()) {
    const Result<MeshFormat> named = mesh_format_of(request.mesh);
    if (!named) return named.error();
    format = *named;
  }
  if (!request.points.empty()) {
    if (Status made = check_makes_cloud(*request.method); !made) return std::move(made).error();
  }
  Result<Input> input = input_of(request, context);
  if (!input) return std::move(input).error();
  Reconstruction& result = input->made.result;
  orient(result, request.parameters, input->cloud.source.viewpoint);
  std::vector<std::byte> points;
  if (!request.points.empty()) {
    points = encode_cloud_ply(result.mesh.positions, result.mesh.normals, result.mesh.colors);
  }
  context.section(kFinishedUntil);
  if (Status finished = finish(result, request.parameters, context); !finished) return std::move(finished).error();
  if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled before the mesh was written"};
  context.section(1);
  const Json& preparing = input->made.preparing;
  Result<Json> report = format ? deliver(request, input->cloud, preparing, result, *format, context)
                               : measure_unwritten(request, input->cloud, preparing, result, context);
  if (!report) return report;
  if (!request.points.empty()) {
    context.enter("write", 1);
    if (Status written = write_file(request.points, points); !written) return std::move(written).error();
  }
  Result<std::string> digest = request.cloud_sha256.empty() ? digest_of(request.cloud) : request.cloud_sha256;
  if (!digest) return std::move(digest).error();
  (*report)["provenance"]["input_sha256"] = *digest;
  add_run(*report, context);
  return report;
}

Result<Json> measure_unguarded(const std::filesystem::path& mesh,
                               const std::optional<std::filesystem::path>& cloud_path, bool self_intersections,
                               Context& context) {
  context.section(1);
  context.enter("read", 0.3);
  const Result<TriangleMesh> decoded = read_mesh(mesh);
  if (!decoded) return decoded.error();
  std::optional<PointCloud> cloud;
  if (cloud_path) {
    Result<PointCloud> loaded = load_cloud(*cloud_path, {}, Missing::drop, {}, context);
    if (!loaded) return std::move(loaded).error();
    cloud = std::move(*loaded);
  }
  context.section(1);
  context.enter("quality", 0.6);
  const Topology topology = topology_of(*decoded);
  std::optional<PointUse> use;
  if (cloud) use = use_of_points(*cloud, *decoded, topology, true);
  std::optional<std::size_t> pairs;
  if (self_intersections) pairs = count_self_intersections(*decoded);
  Json report{{"cloud", cloud ? cloud_json(*cloud) : Json(nullptr)},
              {"mesh", topology_json(topology)},
              {"warnings", cloud ? Json(cloud->warnings) : Json::array()},
              {"quality", quality_json(measure_quality(*decoded, topology), use, pairs)},
              {"certificate", nullptr},
              {"provenance", {{"generator", "surfaced"}, {"version", version()}}}};
  for (std::string& warning : warnings_of_openings(report.at("mesh"))) report["warnings"].push_back(std::move(warning));
  if (!decoded->triangles.empty()) {
    context.enter("certificate", 1);
    const Result<Certificate> certificate = certify(*decoded, context);
    if (!certificate) return certificate.error();
    report["certificate"] = certificate_json(*certificate);
    for (std::string& warning : certificate_warnings(*certificate)) report["warnings"].push_back(std::move(warning));
  }
  add_run(report, context);
  return report;
}

/// The room's wall, for what the rooms below have none of: measuring, encoding, reports. Only memory that has run out
/// goes on, to whoever set its limit.
template <class Work>
auto guarded(Context& context, Work work) -> decltype(work()) {
  const auto stage = [&] {
    const std::vector<Stage> stages = context.finish();
    return stages.empty() ? std::string("before the first") : stages.back().name;
  };
  try {
    return work();
  } catch (const Cancelled&) {
    return Error{ErrorCode::cancelled, "cancelled at stage " + stage()};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& failure) {
    return Error{ErrorCode::method_failed, "the stage " + stage() + " failed: " + reason_of(failure)};
  }
}

}  // namespace

Result<Reconstruction> run(const PointCloud& cloud, const MethodInfo& method, const Json& parameters,
                           Context& context) {
  return guarded(context, [&] { return run_unguarded(cloud, method, parameters, context); });
}

Result<Json> reconstruct_file(const FileRequest& request, Context& context) {
  return guarded(context, [&] { return reconstruct_unguarded(request, context); });
}

Result<Json> measure_file(const std::filesystem::path& mesh, const std::optional<std::filesystem::path>& cloud_path,
                          bool self_intersections, Context& context) {
  return guarded(context, [&] { return measure_unguarded(mesh, cloud_path, self_intersections, context); });
}

}  // namespace surfaced
