// The way of a cloud: read -> method -> encode -> decode and measure -> write.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "reconstruction/methods.hpp"
#include "reconstruction/position_set.hpp"
#include "reconstruction/preparing_stage.hpp"
#include "reconstruction/provenance.hpp"
#include "reconstruction/report.hpp"

namespace surfaced {
namespace {

// Shares of the progress bar.
constexpr double kReadUntil = 0.1;
constexpr double kPreparedUntil = 0.3;
constexpr double kMethodUntil = 0.9;

/// Drops the vertices that no triangle uses, keeping the order of the others.
void compact(TriangleMesh& mesh) {
  std::vector<bool> used(mesh.positions.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const VertexIndex v : t) used[v] = true;
  }
  std::vector<VertexIndex> renumbered(mesh.positions.size());
  std::size_t kept = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    mesh.positions[kept] = mesh.positions[v];
    if (!mesh.normals.empty()) mesh.normals[kept] = mesh.normals[v];
    if (!mesh.colors.empty()) mesh.colors[kept] = mesh.colors[v];
    renumbered[v] = VertexIndex(kept++);
  }
  mesh.positions.resize(kept);
  if (!mesh.normals.empty()) mesh.normals.resize(kept);
  if (!mesh.colors.empty()) mesh.colors.resize(kept);
  for (Triangle& t : mesh.triangles) {
    for (VertexIndex& v : t) v = renumbered[v];
  }
}

Point3 without_minus_zero(const Point3& p) { return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; }

/// What the encoding did to the vertices, which keep their order.
struct EncodingEffect {
  double max_error = 0;
  std::size_t merged_vertices = 0;
};

EncodingEffect effect_of_encoding(const TriangleMesh& computed, const TriangleMesh& decoded) {
  EncodingEffect effect;
  PositionSet distinct(decoded.positions.size());
  for (std::size_t v = 0; v < decoded.positions.size(); ++v) {
    effect.max_error = std::max(effect.max_error, norm(decoded.positions[v] - computed.positions[v]));
    if (!distinct.insert(without_minus_zero(decoded.positions[v]))) ++effect.merged_vertices;
  }
  return effect;
}

/// An STL has no vertices, only corners: those of the computed mesh are compared with what the file holds of each.
EncodingEffect effect_of_stl(const TriangleMesh& computed) {
  TriangleMesh stored;
  stored.positions = positions_in_stl(computed);
  return effect_of_encoding(computed, stored);
}

/// Distinct points of the cloud that no triangle of the mesh uses. A point is a vertex if it equals one
/// after both are rounded to float32, the precision of mesh files.
PointUse use_of_points(const PointCloud& cloud, const TriangleMesh& mesh, const Topology& topology, bool interpolates) {
  // Adding 0 makes +0 of the -0 that tiny negative numbers become.
  const auto rounded = [](const Point3& p) {
    Point3 r;
    for (std::size_t axis = 0; axis < 3; ++axis) r[axis] = static_cast<double>(static_cast<float>(p[axis])) + 0.0;
    return r;
  };
  PositionSet vertices(mesh.positions.size());
  std::vector<bool> seen(mesh.positions.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const VertexIndex v : t) {
      if (!seen[v]) vertices.insert(rounded(mesh.positions[v]));
      seen[v] = true;
    }
  }
  std::vector<Point3> unused;
  for (const Point3& p : cloud.positions) {
    if (!vertices.contains(rounded(p))) unused.push_back(p);
  }
  PointUse use{unused.size(), std::nullopt};
  if (interpolates && topology.closed) use.interior = count_points_inside(mesh, unused);
  return use;
}

bool asks_for_preparing(const Json& parameters) {
  return parameters.at("outliers") != "none" || parameters.at("sample") != "none";
}

Result<PointCloud> load(const std::filesystem::path& path, const ReadLimits& limits, std::string_view name,
                        Context& context) {
  context.section(kReadUntil);
  context.enter("read", 1);
  Result<RawCloud> raw = read_cloud(path, limits, name);
  if (!raw) return std::move(raw).error();
  return make_cloud(std::move(*raw), context.threads());
}

/// What a reader of the encoded mesh gets, measured.
struct Measured {
  Json mesh;
  Json quality;
  Json encoding;
  /// None for methods without one.
  std::optional<Certificate> certificate = std::nullopt;
};

Json quality_of(const Reconstruction& result, const PointCloud& cloud, bool interpolates, const TriangleMesh& mesh,
                const Topology& topology) {
  return quality_json(measure_quality(mesh, topology), use_of_points(cloud, result.mesh, topology, interpolates),
                      std::nullopt);
}

Result<Measured> measure_encoded(const Reconstruction& result, const PointCloud& cloud, bool interpolates,
                                 const TriangleMesh& decoded, MeshFormat format) {
  const bool stl = format == MeshFormat::stl;
  if (!stl && decoded.positions.size() != result.mesh.positions.size()) {
    return Error{ErrorCode::internal_error, "the encoded mesh decodes to " + std::to_string(decoded.positions.size()) +
                                                " vertices instead of " + std::to_string(result.mesh.positions.size())};
  }
  const Topology topology = topology_of(decoded);
  const EncodingEffect effect = stl ? effect_of_stl(result.mesh) : effect_of_encoding(result.mesh, decoded);
  return Measured{
      .mesh = topology_json(topology),
      .quality = quality_of(result, cloud, interpolates, decoded, topology),
      .encoding = Json{
          {"format", name_of(format)}, {"max_error", effect.max_error}, {"merged_vertices", effect.merged_vertices}}};
}

/// What a printer asks: how large, in which unit, how much material.
Json printing_json(const TriangleMesh& mesh, const Json& quality, const Json& parameters) {
  return Json{{"unit", parameters.at("unit")},
              {"bounding_box", bounds_of(mesh.positions).high - bounds_of(mesh.positions).low},
              {"volume", quality.at("volume")}};
}

/// The part of the report that is the same for every run on the same points.
Json reproducible_report(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                         const Reconstruction& result, const Measured& measured) {
  std::vector<std::string> warnings = cloud.warnings;
  warnings.insert(warnings.end(), result.warnings.begin(), result.warnings.end());
  if (const Json& open = measured.mesh.at("boundary_edges"); open > 0) {
    warnings.push_back("the mesh is open: " + open.dump() + " edges have one triangle");
  }
  if (!measured.encoding.is_null() && measured.encoding.at("merged_vertices") > 0) {
    warnings.push_back(measured.encoding.at("merged_vertices").dump() +
                       " vertices share a position with another after encoding");
  }
  if (measured.certificate)
    std::ranges::copy(certificate_warnings(*measured.certificate), std::back_inserter(warnings));
  Json report{{"method", request.method->id}, {"parameters", request.parameters},
              {"cloud", cloud_json(cloud)},   {"mesh", measured.mesh},
              {"warnings", warnings},         {"quality", measured.quality}};
  report["preparing"] = preparing;
  report["printing"] = printing_json(result.mesh, measured.quality, request.parameters);
  if (measured.certificate) report["certificate"] = certificate_json(*measured.certificate);
  report["method_statistics"] = result.statistics;
  report["hole_filling"] = result.hole_filling;
  report["encoding"] = measured.encoding;
  report["provenance"] = Json{{"generator", "surfaced"}, {"version", version()}};
  return report;
}

/// The certificate of the mesh, where the method has one.
Status add_certificate(const FileRequest& request, const TriangleMesh& mesh, Measured& measured, Context& context) {
  if (!method_of(*request.method).certified) return Done{};
  Result<Certificate> certificate = certify(mesh, context);
  if (!certificate) return std::move(certificate).error();
  measured.certificate = std::move(*certificate);
  return Done{};
}

/// Encodes the mesh, measures the decoded file and writes it; returns the reproducible report.
Result<Json> deliver(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                     const Reconstruction& result, MeshFormat format, Context& context) {
  context.enter("quality", 0.7);
  EncodeOptions options = encode_options_of(request.parameters);
  Result<std::vector<std::byte>> bytes = encode_mesh(result.mesh, format, options);
  if (!bytes) return std::move(bytes).error();
  Result<TriangleMesh> decoded = decode_mesh(*bytes, "the encoded mesh");
  if (!decoded) return std::move(decoded).error();
  const bool interpolates = method_of(*request.method).interpolates;
  Result<Measured> measured = measure_encoded(result, cloud, interpolates, *decoded, format);
  if (!measured) return std::move(measured).error();
  if (Status certified = add_certificate(request, *decoded, *measured, context); !certified) {
    return std::move(certified).error();
  }
  Json report = reproducible_report(request, cloud, preparing, result, *measured);

  context.enter("write", 1);
  if (format == MeshFormat::glb || format == MeshFormat::gltf) {
    options.extras_json = report.dump();
    bytes = encode_mesh(result.mesh, format, options);
    if (!bytes) return std::move(bytes).error();
  }
  if (Status written = write_file(request.mesh, *bytes); !written) return std::move(written).error();
  report["encoding"]["bytes"] = bytes->size();
  return report;
}

/// The report where only points are asked for: of the mesh as computed.
Result<Json> measure_unwritten(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                               const Reconstruction& result, Context& context) {
  context.enter("quality", 1);
  const Topology topology = topology_of(result.mesh);
  const bool interpolates = method_of(*request.method).interpolates;
  Measured measured{.mesh = topology_json(topology),
                    .quality = quality_of(result, cloud, interpolates, result.mesh, topology),
                    .encoding = nullptr};
  if (Status certified = add_certificate(request, result.mesh, measured, context); !certified) {
    return std::move(certified).error();
  }
  return reproducible_report(request, cloud, preparing, result, measured);
}

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

void finish(Reconstruction& result, const Json& parameters) {
  if (const double fraction = parameters.at("drop_parts"); fraction > 0) drop_small_parts(result, fraction);
  compact(result.mesh);
  sort_triangles(result.mesh);
}

}  // namespace

Result<Reconstruction> run(const PointCloud& cloud, const MethodInfo& method, const Json& parameters,
                           Context& context) {
  Result<Reconstruction> result = engine_of(cloud, method, parameters, context);
  if (result) finish(*result, parameters);
  return result;
}

Result<Json> reconstruct_file(const FileRequest& request, Context& context) {
  std::optional<MeshFormat> format;
  if (!request.mesh.empty()) {
    const Result<MeshFormat> named = mesh_format_of(request.mesh);
    if (!named) return named.error();
    format = *named;
  }
  if (!request.points.empty()) {
    if (Status made = check_makes_cloud(*request.method); !made) return std::move(made).error();
  }
  const Result<PointCloud> cloud = load(request.cloud, request.limits, request.cloud_name, context);
  if (!cloud) return cloud.error();
  std::optional<Prepared> prepared;
  if (asks_for_preparing(request.parameters)) {
    context.section(kPreparedUntil);
    Result<Prepared> ready = prepare(*cloud, request.parameters, context);
    if (!ready) return std::move(ready).error();
    prepared = std::move(*ready);
  }
  context.section(kMethodUntil);
  Result<Reconstruction> result =
      engine_of(prepared ? prepared->cloud : *cloud, *request.method, request.parameters, context);
  if (!result) return std::move(result).error();
  std::vector<std::byte> points;
  if (!request.points.empty()) {
    points = encode_cloud_ply(result->mesh.positions, result->mesh.normals, result->mesh.colors);
  }
  finish(*result, request.parameters);
  if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled before the mesh was written"};
  context.section(1);
  const Json preparing = prepared ? prepared->stages : Json::array();
  Result<Json> report = format ? deliver(request, *cloud, preparing, *result, *format, context)
                               : measure_unwritten(request, *cloud, preparing, *result, context);
  if (!report) return report;
  if (!request.points.empty()) {
    context.enter("write", 1);
    if (Status written = write_file(request.points, points); !written) return std::move(written).error();
  }
  Result<std::string> digest = sha256_of_file(request.cloud);
  if (!digest) return std::move(digest).error();
  (*report)["provenance"]["input_sha256"] = *digest;
  add_run(*report, context);
  return report;
}

Result<Json> measure_file(const std::filesystem::path& mesh, const std::optional<std::filesystem::path>& cloud_path,
                          bool self_intersections, Context& context) {
  context.section(1);
  context.enter("read", 0.3);
  const Result<TriangleMesh> decoded = read_mesh(mesh);
  if (!decoded) return decoded.error();
  std::optional<PointCloud> cloud;
  if (cloud_path) {
    Result<PointCloud> loaded = load(*cloud_path, {}, {}, context);
    if (!loaded) return std::move(loaded).error();
    cloud = std::move(*loaded);
  }
  context.section(1);
  context.enter("quality", 1);
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
  if (!decoded->triangles.empty()) {
    const Result<Certificate> certificate = certify(*decoded, context);
    if (!certificate) return certificate.error();
    report["certificate"] = certificate_json(*certificate);
    for (std::string& warning : certificate_warnings(*certificate)) report["warnings"].push_back(std::move(warning));
  }
  add_run(report, context);
  return report;
}

}  // namespace surfaced
