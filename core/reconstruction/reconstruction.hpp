// SPDX-License-Identifier: GPL-3.0-or-later
// The façade: which methods there are, what parameters they take, and the way of a cloud through one
// of them to a mesh and its report. Everything outside core/ comes in through here (and io, base).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "io/io.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// Keeps the order in which fields were added, so that a report always has the same bytes.
using Json = nlohmann::ordered_json;

/// What a method is, for people and for programs.
struct MethodInfo {
  std::string id;
  std::string title;
  std::string summary;
  /// Where the method comes from: paper or library.
  std::string source;
  /// What holds for every result of the method on the points that it gets, a sentence each. The stages before and
  /// after it (`sample`, `simplify`, ...) give it other points and change its mesh.
  std::vector<std::string> guarantees;
  /// What does not hold, or is only reported.
  std::vector<std::string> limitations;
  /// JSON Schema (2020-12) of the parameters, an object with defaults, ranges, units and texts.
  Json parameters;
  /// Whether it has points to give: the input's, upsampled and completed where holes were filled.
  bool makes_cloud = false;
};

/// Error unknown_output unless the method makes a cloud.
Status check_makes_cloud(const MethodInfo& method);

/// All methods, the default one first.
std::span<const MethodInfo> methods();

/// The method, or unknown_method naming those there are.
Result<const MethodInfo*> find_method(std::string_view id);

/// The list of methods as JSON: an array of objects `id, title, summary, source, guarantees,
/// limitations, outputs, parameters`.
Json methods_json();
Json method_json(const MethodInfo& method);

/// Checks parameters (a JSON object) against the method's schema and fills in the defaults.
/// @return  all parameters in the schema's order; unknown_parameter or invalid_parameter with the name,
///          the value and what is allowed.
Result<Json> check_parameters(const MethodInfo& method, const Json& given);

/// The same for parameters given as text (`--param name=value`, query strings): values are read as the
/// schema's type first. A name given twice is invalid_parameter.
Result<Json> parameters_from_text(const MethodInfo& method, std::span<const std::pair<std::string, std::string>> given);

/// Processor time and memory.
struct Cost {
  double seconds = 0;
  std::uint64_t bytes = 0;
};

/// The bound that holds for every cloud of so many points and all parameters, for the method and the stages around it:
/// a thousand times the time that such clouds usually take, and a hundred times their memory. What needs more does
/// not end sensibly.
Cost most_cost(const MethodInfo& method, std::size_t points);

/// What a method made of a cloud.
struct Reconstruction {
  TriangleMesh mesh;
  std::vector<std::string> warnings;
  /// The method's own statistics, for the report's field `method_statistics`; may be null.
  Json statistics;
  /// Which side is the front, and why, for the report's field `orientation`; null if nothing was to be decided.
  Json orientation = nullptr;
  /// What drop_parts and simplify did, for the report's field `finishing`: name, counts in and out.
  Json finishing = Json::array();
  /// What the stage `fill_holes` did, for the report's field `hole_filling`; null if it did not run.
  Json hole_filling = nullptr;
};

/// Runs a method with checked parameters, and the stages before and after it that they ask for. The mesh is sorted, has
/// no unused vertices (vertices_of_input tells which is which point), carries the cloud's normals and colours, and is
/// the same for any number of threads and any order of the points.
/// @return  method_failed for an empty mesh; cancelled; too_few_points, collinear, coplanar.
Result<Reconstruction> run(const PointCloud& cloud, const MethodInfo& method, const Json& parameters, Context& context);

/// How the parameters of a job want its mesh written; what they leave out is as by default. `vertex_quality` is
/// measured here.
EncodeOptions encode_options_of(const Json& parameters, const TriangleMesh& mesh);

/// A mesh in another format than its first. The extras of a glTF are the report of the job, if there is one, with what
/// this encoding did to the vertices (added to the report's own `encoding.max_error`, if the mesh was read from that
/// file: null says that it was not), and without what differs from run to run.
/// @return  the bytes of the file; errors as of encode_mesh.
Result<std::vector<std::byte>> encode_again(const TriangleMesh& mesh, MeshFormat format, const Json& parameters,
                                            Json report);

/// The same into a file, in the format of its name.
Status write_again(const TriangleMesh& mesh, const std::filesystem::path& file, const Json& parameters, Json report);

/// One file in, one file out.
struct FileRequest {
  std::filesystem::path cloud;
  /// Empty: no mesh is written, only `points`.
  std::filesystem::path mesh = {};
  const MethodInfo* method = nullptr;
  /// As check_parameters returns them.
  Json parameters;
  ReadLimits limits = {};
  /// What messages call the cloud; empty: its file name.
  std::string cloud_name = {};
  /// SHA-256 of the cloud's file, for who has it; empty: the file is read once more for it.
  std::string cloud_sha256 = {};
  /// Where the method's cloud goes, as PLY; empty: nowhere.
  std::filesystem::path points = {};
  /// The same mesh in further formats: each is encoded from the mesh in memory, not from the first file.
  std::vector<std::filesystem::path> more_meshes = {};
  /// Where the mesh goes as a PLY that loses nothing, if `mesh` loses anything of it; empty: nowhere.
  std::filesystem::path kept = {};
  /// Whether a glTF may name files beside it.
  bool files_beside = false;
  /// Told how many distinct points the cloud has, before the method runs; its error ends the run. May be empty.
  std::function<Status(std::size_t points)> on_read = {};
};

/// Reads the cloud, runs the method, encodes the mesh, measures what a reader of the encoded mesh
/// gets, and writes it (atomically). The only way from a file to a mesh: the command and the
/// service's child process both take it.
/// @return  the report (proto/schema/report.json); unknown_output if points are asked of a method that makes none.
Result<Json> reconstruct_file(const FileRequest& request, Context& context);

/// Report of any mesh file: its topology and quality, and against a cloud where one is given.
Result<Json> measure_file(const std::filesystem::path& mesh, const std::optional<std::filesystem::path>& cloud,
                          bool self_intersections, Context& context);

/// Version of the library, as in CMakeLists.txt.
std::string_view version();

}  // namespace surfaced
