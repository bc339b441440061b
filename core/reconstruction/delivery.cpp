// SPDX-License-Identifier: GPL-3.0-or-later
// Encode -> decode and measure -> write.
#include "reconstruction/delivery.hpp"

#include <algorithm>
#include <iterator>

#include "reconstruction/encoding.hpp"
#include "reconstruction/finishing_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/orienting_stage.hpp"
#include "reconstruction/position_set.hpp"
#include "reconstruction/preparing_stage.hpp"
#include "reconstruction/report.hpp"

namespace surfaced {
namespace {

/// Whether points that are no vertices can be told to be inside.
bool vertices_are_points(const FileRequest& request) {
  return method_of(*request.method).interpolates && !asks_for_simplifying(request.parameters) &&
         !moves_points(request.parameters);
}

/// What a reader of the encoded mesh gets, measured.
struct Measured {
  Json mesh;
  Json quality;
  Json encoding;
  std::vector<std::string> encoding_warnings{};
  /// None for methods without one.
  std::optional<Certificate> certificate = std::nullopt;
};

Json quality_of(const Reconstruction& result, const PointCloud& cloud, bool interpolates, const TriangleMesh& mesh,
                const Topology& topology) {
  std::optional<std::size_t> crossings;
  if (!result.hole_filling.is_null()) crossings = count_self_intersections(mesh);
  return quality_json(measure_quality(mesh, topology), use_of_points(cloud, result.mesh, topology, interpolates),
                      crossings);
}

Result<Measured> measure_encoded(const FileRequest& request, const Reconstruction& result, const PointCloud& cloud,
                                 const TriangleMesh& decoded, MeshFormat format, const EncodeOptions& options,
                                 Context& context) {
  const Result<EncodingEffect> effect = effect_of_encoding(result.mesh, decoded, format, options, context);
  if (!effect) return effect.error();
  const Topology topology = topology_of(decoded);
  return Measured{.mesh = topology_json(topology),
                  .quality = quality_of(result, cloud, vertices_are_points(request), decoded, topology),
                  .encoding = encoding_json(*effect, format, request.parameters),
                  .encoding_warnings = encoding_warnings(*effect)};
}

/// The part of the report that is the same for every run on the same points.
Json reproducible_report(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                         const Reconstruction& result, const Measured& measured, std::optional<MeshFormat> format) {
  std::vector<std::string> warnings = cloud.warnings;
  warnings.insert(warnings.end(), result.warnings.begin(), result.warnings.end());
  std::ranges::copy(warnings_of_openings(measured.mesh), std::back_inserter(warnings));
  std::ranges::copy(measured.encoding_warnings, std::back_inserter(warnings));
  if (format) std::ranges::copy(unheeded_packing(*format, request.parameters), std::back_inserter(warnings));
  if (measured.certificate)
    std::ranges::copy(certificate_warnings(*measured.certificate), std::back_inserter(warnings));
  std::ranges::copy(warnings_of_inward_faces(measured.quality.at("volume")), std::back_inserter(warnings));
  Json printing = printing_json(result.mesh, measured.quality.at("volume"), request.parameters, format, warnings);
  Json report{{"method", request.method->id}, {"parameters", request.parameters},
              {"cloud", cloud_json(cloud)},   {"mesh", measured.mesh},
              {"warnings", warnings},         {"quality", measured.quality}};
  report["preparing"] = preparing;
  report["orientation"] = result.orientation;
  report["finishing"] = result.finishing;
  report["printing"] = std::move(printing);
  if (measured.certificate) report["certificate"] = certificate_json(*measured.certificate);
  report["method_statistics"] = result.statistics;
  report["hole_filling"] = result.hole_filling;
  report["encoding"] = measured.encoding;
  report["provenance"] = Json{{"generator", "surfaced"}, {"version", version()}};
  return report;
}

/// The certificate of the mesh, where the method has one.
Status add_certificate(const FileRequest& request, const TriangleMesh& mesh, Measured& measured, Context& context) {
  if (!method_of(*request.method).certified || request.parameters.at("certificate") == "no") return Done{};
  context.enter("certificate", 0.9);
  Result<Certificate> certificate = certify(mesh, context);
  if (!certificate) return std::move(certificate).error();
  measured.certificate = std::move(*certificate);
  return Done{};
}

bool loses_anything(const TriangleMesh& mesh, const TriangleMesh& decoded) {
  return decoded.positions != mesh.positions || decoded.triangles != mesh.triangles ||
         decoded.normals != mesh.normals || decoded.colors != mesh.colors;
}

/// The mesh without any loss, for formats that are asked for later.
Status keep(const TriangleMesh& mesh, const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = encode_mesh(mesh, MeshFormat::ply, {});
  return bytes ? write_file(file, *bytes) : bytes.error();
}

/// The mesh in the further formats that are asked for.
Status write_more(const FileRequest& request, const TriangleMesh& mesh, Json report) {
  report["encoding"] = nullptr;
  for (const std::filesystem::path& file : request.more_meshes) {
    if (Status written = write_again(mesh, file, request.parameters, report); !written) return written;
  }
  return Done{};
}

}  // namespace

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

std::vector<std::string> warnings_of_openings(const Json& topology) {
  const Json& open = topology.at("boundary_edges");
  if (open == 0) return {};
  return {"the mesh is open: " + open.dump() + " edges have one triangle"};
}

Result<Json> deliver(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                     const Reconstruction& result, MeshFormat format, Context& context) {
  context.enter("quality", 0.7);
  EncodeOptions options = encode_options_of(request.parameters, result.mesh);
  Result<std::vector<std::byte>> bytes = encode_mesh(result.mesh, format, options);
  if (!bytes) return std::move(bytes).error();
  Result<TriangleMesh> decoded = decode_mesh(*bytes, "the encoded mesh");
  if (!decoded) return std::move(decoded).error();
  Result<Measured> measured = measure_encoded(request, result, cloud, *decoded, format, options, context);
  if (!measured) return std::move(measured).error();
  if (Status certified = add_certificate(request, *decoded, *measured, context); !certified) {
    return std::move(certified).error();
  }
  Json report = reproducible_report(request, cloud, preparing, result, *measured, format);

  context.enter("write", 1);
  if (format == MeshFormat::glb || format == MeshFormat::gltf) {
    options.extras_json = report.dump();
    bytes = encode_mesh(result.mesh, format, options);
    if (!bytes) return std::move(bytes).error();
  }
  if (Status written = write_file(request.mesh, *bytes); !written) return std::move(written).error();
  if (!request.kept.empty() && loses_anything(result.mesh, *decoded)) {
    if (Status kept = keep(result.mesh, request.kept); !kept) return std::move(kept).error();
  }
  if (Status written = write_more(request, result.mesh, report); !written) return std::move(written).error();
  report["encoding"]["bytes"] = bytes->size();
  return report;
}

Result<Json> measure_unwritten(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                               const Reconstruction& result, Context& context) {
  context.enter("quality", 0.7);
  const Topology topology = topology_of(result.mesh);
  Measured measured{.mesh = topology_json(topology),
                    .quality = quality_of(result, cloud, vertices_are_points(request), result.mesh, topology),
                    .encoding = nullptr};
  if (Status certified = add_certificate(request, result.mesh, measured, context); !certified) {
    return std::move(certified).error();
  }
  return reproducible_report(request, cloud, preparing, result, measured, std::nullopt);
}

}  // namespace surfaced
