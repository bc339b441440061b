// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/reading_stage.hpp"

#include <array>

#include "preparing/preparing.hpp"
#include "reconstruction/words.hpp"

namespace surfaced {
namespace {

constexpr int kMostSkipped = 1'000'000;
constexpr std::size_t kLongestColumns = 400;

Json table_properties() {
  return Json{{"columns",
               {{"type", "string"},
                {"pattern", "auto|(-|x|y|z|nx|ny|nz|r|g|b)(,(-|x|y|z|nx|ny|nz|r|g|b))*"},
                {"maxLength", kLongestColumns},
                {"x-allowed", "auto, or x, y, z, nx, ny, nz, r, g, b and - (for a column to leave), apart by commas"},
                {"default", "auto"},
                {"title", "Columns of a text"},
                {"description",
                 "What the columns of a text are, from the left: x,y,z,-,r,g,b for example, with - for one to leave. "
                 "auto tells "
                 "them by a header, or by their values."}}},
              {"separator",
               {{"enum", {"auto", "blank", "tab", "comma", "semicolon", "bar", " ", "\t", ",", ";", "|"}},
                {"default", "auto"},
                {"title", "Separator of a text"},
                {"description", "What stands between the values of a text; blank is any run of blanks and tabs."}}},
              {"decimal",
               {{"enum", {"auto", "point", "comma", ".", ","}},
                {"default", "auto"},
                {"title", "Decimal sign of a text"},
                {"description", "auto takes a comma as the decimal sign where it cannot separate values."}}},
              {"skip",
               {{"type", "integer"},
                {"minimum", 0},
                {"maximum", kMostSkipped},
                {"default", 0},
                {"title", "Lines to skip in a text"},
                {"description", "Lines at the beginning of a text that are passed over."},
                {"x-unit", "lines"}}}};
}

Json splat_properties() {
  const auto none_or = [](Json number) { return Json{Json{{"const", "none"}}, std::move(number)}; };
  return Json{{"splat_opacity",
               {{"oneOf", none_or({{"type", "number"}, {"minimum", 0}, {"maximum", 1}})},
                {"default", "none"},
                {"title", "Least opacity of Gaussians"},
                {"description", "Of a PLY of Gaussian splats: leaves out those of less opacity than this."},
                {"x-unit", "1"}}},
              {"splat_scale",
               {{"oneOf", none_or({{"type", "number"}, {"exclusiveMinimum", 0}})},
                {"default", "none"},
                {"title", "Largest Gaussians"},
                {"description", "Of a PLY of Gaussian splats: leaves out those whose longest half-axis exceeds this."},
                {"x-unit", "input"}}}};
}

template <class T>
T named(const Json& value, const auto& table) {
  for (const auto& [name, meaning] : table) {
    if (value == name) return meaning;
  }
  return table.front().second;
}

Error with_name(Error error, const std::string& name) {
  error.detail = name + ": " + error.detail;
  return error;
}

}  // namespace

Json reading_properties() {
  Json properties{
      {"input",
       {{"enum", {"cloud", "mesh"}},
        {"default", "cloud"},
        {"title", "What the file is"},
        {"description",
         "mesh keeps the faces of the file: no method and no stage before it runs, the mesh is finished, "
         "measured and written. cloud takes the vertices as points."}}},
      {"missing",
       {{"enum", {"drop", "refuse"}},
        {"default", "drop"},
        {"title", "Points without a measurement"},
        {"description",
         "drop leaves out points with a coordinate that is NaN or infinite, and points at exactly 0 0 0 if "
         "they are many and lie off all others. refuse takes no file with the former, and the latter as "
         "points."}}},
      {"truncated",
       {{"enum", {"refuse", "take"}},
        {"default", "refuse"},
        {"title", "Files that were cut off"},
        {"description", "take reads a LAS or PTS as far as it goes where it has fewer points than it declares."}}}};
  const Json table = table_properties();
  for (const auto& [name, schema] : table.items()) properties[name] = schema;
  const Json splats = splat_properties();
  for (const auto& [name, schema] : splats.items()) properties[name] = schema;
  return properties;
}

bool asks_for_mesh(const Json& parameters) { return parameters.at("input") == "mesh"; }

ReadOptions read_options_of(const Json& parameters, const ReadLimits& limits, bool files_beside) {
  constexpr auto kSeparators = std::to_array<std::pair<const char*, Separator>>({{"auto", Separator::guessed},
                                                                                 {"blank", Separator::blank},
                                                                                 {" ", Separator::blank},
                                                                                 {"tab", Separator::tab},
                                                                                 {"\t", Separator::tab},
                                                                                 {"comma", Separator::comma},
                                                                                 {",", Separator::comma},
                                                                                 {"semicolon", Separator::semicolon},
                                                                                 {";", Separator::semicolon},
                                                                                 {"bar", Separator::bar},
                                                                                 {"|", Separator::bar}});
  constexpr auto kDecimals = std::to_array<std::pair<const char*, Decimal>>({{"auto", Decimal::guessed},
                                                                             {"point", Decimal::point},
                                                                             {".", Decimal::point},
                                                                             {"comma", Decimal::comma},
                                                                             {",", Decimal::comma}});
  ReadOptions options(limits);
  const std::string columns = parameters.at("columns");
  options.table = {.columns = columns == "auto" ? std::string() : columns,
                   .separator = named<Separator>(parameters.at("separator"), kSeparators),
                   .decimal = named<Decimal>(parameters.at("decimal"), kDecimals),
                   .skip = parameters.at("skip").get<std::size_t>()};
  const auto number = [&](const char* name) {
    const Json& value = parameters.at(name);
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
  };
  options.splats = {.least_opacity = number("splat_opacity"), .largest_scale = number("splat_scale")};
  options.take_truncated = parameters.at("truncated") == "take";
  options.files_beside = files_beside;
  return options;
}

Result<PointCloud> load_cloud(const std::filesystem::path& path, const ReadOptions& options, Missing missing,
                              std::string_view name, Context& context) {
  const std::string called = name.empty() ? path.filename().string() : std::string(name);
  Result<RawCloud> raw = read_cloud(path, options, name);
  if (!raw) return std::move(raw).error();
  Result<PointCloud> cloud = make_cloud(std::move(*raw), context.threads(), missing);
  if (!cloud) return with_name(cloud.error(), called);
  if (on_a_rounded_line(cloud->positions)) {
    return with_name({ErrorCode::collinear,
                      "all " + std::to_string(cloud->size()) + " distinct points lie on one line, but for rounding"},
                     called);
  }
  return cloud;
}

std::vector<std::string> doubts_of(const PointCloud& cloud, const Json& parameters, Context& context) {
  std::vector<std::string> doubts;
  if (const auto steps = float_steps_of(cloud.positions, context.threads())) {
    doubts.push_back("the coordinates lie on steps of " + briefly(steps->step) +
                     ", those of float32 so far from 0, while the points are " + briefly(steps->spacing) +
                     " apart: digits were lost before this file was written; write it with double coordinates, or move "
                     "the cloud to the origin first");
  }
  if (parameters.at("fuse") != "none") return doubts;
  if (const auto repeats = near_repeats_of(cloud.positions)) {
    const auto percent = static_cast<int>(100 * repeats->share + 0.5);
    doubts.push_back("near-repeats: " + std::to_string(percent) + " % of the points have another within about " +
                     briefly(repeats->near) + ", while the next is " + briefly(repeats->far) +
                     " away, as in several scans of one thing; fuse=auto merges points within " +
                     briefly(repeats->tolerance));
  }
  return doubts;
}

Result<LoadedMesh> load_mesh(const std::filesystem::path& path, const ReadOptions& options, std::string_view name,
                             Context& context) {
  std::vector<std::string> warnings;
  Result<TriangleMesh> mesh = read_mesh(path, &warnings, options, name);
  if (!mesh) return std::move(mesh).error();
  const std::string called = name.empty() ? path.filename().string() : std::string(name);
  if (mesh->positions.size() > options.limits.max_points) {
    return Error{ErrorCode::too_many_points, called + ": " + std::to_string(mesh->positions.size()) +
                                                 " vertices; the limit is " +
                                                 std::to_string(options.limits.max_points)};
  }
  if (mesh->triangles.empty())
    return Error{ErrorCode::empty_input, called + " has no triangles; input=cloud takes its points"};
  RawCloud raw{
      .positions = mesh->positions, .normals = mesh->normals, .colors = mesh->colors, .warnings = std::move(warnings)};
  raw.source.format = "mesh";
  raw.source.faces = mesh->triangles.size();
  Result<PointCloud> cloud = make_cloud(std::move(raw), context.threads());
  if (!cloud) return with_name(cloud.error(), called);
  return LoadedMesh{std::move(*mesh), std::move(*cloud)};
}

}  // namespace surfaced
