// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/finishing_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/text.hpp"
#include "quality/quality.hpp"
#include "reconstruction/preparing_stage.hpp"
#include "reconstruction/words.hpp"
#include "simplification/simplification.hpp"

namespace surfaced {
namespace {

/// Fewest triangles that a closed body has.
constexpr int kFewestTriangles = 4;
/// More than any mesh can have: triangles are numbered by 32 bits.
constexpr std::uint32_t kMostTriangles = std::numeric_limits<std::uint32_t>::max();
/// Two lines of the usual nozzle of 0.4 mm: what printers of plastic threads ask of a wall.
constexpr double kUsualWallInMillimetres = 0.8;
constexpr std::size_t kWallSamples = 2000;
/// Edges of bodies are thin by nature; a warning wants more than that.
constexpr double kThinShareToWarn = 0.01;

Json simplify_property() {
  return {
      {"oneOf",
       {Json{{"const", "none"}}, Json{{"type", "integer"}, {"minimum", kFewestTriangles}, {"maximum", kMostTriangles}},
        Json{{"type", "number"}, {"exclusiveMinimum", 0}, {"maximum", 0.5}}}},
      {"default", "none"},
      {"title", "Fewer triangles"},
      {"description",
       "A whole number from 4 on: so many triangles at most. Up to 0.5: as few as keep every point within this "
       "fraction of the diagonal of the mesh's bounding box. The report gives the distance in units of the input."},
      {"x-unit", "triangles or 1"}};
}

Json min_wall_property() {
  return {{"oneOf", {Json{{"enum", {"auto", "none"}}}, Json{{"type", "number"}, {"exclusiveMinimum", 0}}}},
          {"default", "auto"},
          {"title", "Thinnest wall"},
          {"description",
           "Measures a closed mesh's walls at 2,000 places and warns if more than 1 % are thinner than this; auto is "
           "0.8 mm for meshes written as STL or 3MF, and no measurement for others."},
          {"x-unit", "unit"}};
}

void note(Reconstruction& result, const char* name, std::size_t before, Json more = Json::object()) {
  Json entry{{"name", name}, {"triangles_in", before}, {"triangles_out", result.mesh.triangles.size()}};
  for (const auto& [key, value] : more.items()) entry[key] = value;
  result.finishing.push_back(std::move(entry));
}

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

Status simplify(Reconstruction& result, const Json& goal, Context& context) {
  context.enter("simplify", 1);
  const std::size_t before = result.mesh.triangles.size();
  const std::size_t vertices_before = result.mesh.positions.size();
  const double number = goal;
  const double diagonal = bounds_of(result.mesh.positions).diagonal();
  // No more than there are: beyond that a number need not fit an integer.
  const auto most = static_cast<std::size_t>(std::min(number, static_cast<double>(before)));
  Result<Simplified> simplified = number >= kFewestTriangles
                                      ? simplified_to(result.mesh, most, context)
                                      : simplified_within(result.mesh, number * diagonal, context);
  if (!simplified) return std::move(simplified).error();
  result.mesh = std::move(simplified->mesh);
  compact(result.mesh);
  const std::size_t crossing = count_self_intersections(result.mesh);
  note(result, "simplify", before,
       {{"vertices_in", vertices_before},
        {"vertices_out", result.mesh.positions.size()},
        {"max_distance", simplified->distance},
        {"self_intersections", crossing}});
  if (crossing > 0) {
    result.warnings.push_back(std::to_string(crossing) +
                              " pairs of triangles of the simplified mesh cross or touch; simplify to more triangles, "
                              "or not at all, where that must not be");
  }
  if (number >= kFewestTriangles && static_cast<double>(result.mesh.triangles.size()) > number) {
    result.warnings.push_back("simplify stopped at " + std::to_string(result.mesh.triangles.size()) +
                              " triangles: no other edge can be collapsed without changing the topology or turning "
                              "a triangle over");
  }
  return Done{};
}

/// Nine places of viridis (S. van der Walt, N. Smith, 2015), from the least to the greatest value.
constexpr std::array<std::array<std::uint8_t, 3>, 9> kViridis{{{68, 1, 84},
                                                               {71, 44, 122},
                                                               {59, 81, 139},
                                                               {44, 113, 142},
                                                               {33, 144, 141},
                                                               {39, 173, 129},
                                                               {92, 200, 99},
                                                               {170, 220, 50},
                                                               {253, 231, 37}}};

Color4 color_of(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  Color4 color{0, 0, 0, 255};
  for (std::size_t c = 0; c < 3; ++c) {
    const double from = kViridis.at(below).at(c);
    const double to = kViridis.at(below + 1).at(c);
    color.at(c) = static_cast<std::uint8_t>(std::lround(from + (at - static_cast<double>(below)) * (to - from)));
  }
  return color;
}

void color_by_quality(TriangleMesh& mesh, const Json& map) {
  const VertexQuality quality = vertex_quality(mesh);
  const bool edges = map == "l_over_r";
  const double greatest = edges ? kMaxShortestEdgeToCircumradius : kMaxInradiusToLongestEdge;
  mesh.colors.clear();
  for (const float x : edges ? quality.shortest_edge_to_circumradius : quality.inradius_to_longest_edge) {
    mesh.colors.push_back(color_of(static_cast<double>(x) / greatest));
  }
}

/// The thinnest wall that is no cause for a warning, in units of the mesh; none if walls are not to be measured.
std::optional<double> thinnest_wall(const Json& parameters, std::optional<MeshFormat> format) {
  const Json& wall = parameters.at("min_wall");
  if (wall.is_number()) return wall.get<double>();
  const bool for_printers = format == MeshFormat::stl || format == MeshFormat::threemf;
  if (wall == "none" || !for_printers) return std::nullopt;
  constexpr auto kMillimetres =
      std::to_array<std::pair<std::string_view, double>>({{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}});
  for (const auto& [unit, millimetres] : kMillimetres) {
    if (parameters.at("unit") == unit) return kUsualWallInMillimetres / millimetres;
  }
  return std::nullopt;
}

Json walls_json(const TriangleMesh& mesh, double limit, const Json& unit, std::vector<std::string>& warnings) {
  const std::vector<double> walls = wall_thicknesses(mesh, kWallSamples);
  if (walls.empty()) return nullptr;
  const auto thinner = static_cast<std::size_t>(std::ranges::lower_bound(walls, limit) - walls.begin());
  const double share = static_cast<double>(thinner) / static_cast<double>(walls.size());
  if (share > kThinShareToWarn) {
    warnings.push_back(percent(share, 1) + " of the surface lies on walls thinner than " + briefly(limit) + " " +
                       unit.get<std::string>() + ", the thinnest measured " + briefly(walls.front()) + " " +
                       unit.get<std::string>());
  }
  return Json{{"limit", limit},
              {"samples", walls.size()},
              {"least", walls.front()},
              {"p05", walls[walls.size() / 20]},
              {"p50", walls[walls.size() / 2]},
              {"thinner", share}};
}

}  // namespace

Json finishing_properties() {
  return Json{
      {"simplify", simplify_property()},
      {"compression",
       {{"enum", {"none", "draco", "meshopt"}},
        {"default", "none"},
        {"title", "Packing of a GLB or glTF"},
        {"description",
         "draco writes KHR_draco_mesh_compression, meshopt EXT_meshopt_compression; without quantization both keep "
         "every float32."}}},
      {"vertex_quality",
       {{"type", "boolean"},
        {"default", false},
        {"title", "Quality at the vertices"},
        {"description",
         "Writes the least l/R and r/L of the triangles at every vertex: attributes _L_OVER_R and _R_OVER_L of a GLB "
         "or "
         "glTF, properties l_over_r and r_over_l of a PLY."}}},
      {"color_map",
       {{"enum", {"none", "l_over_r", "r_over_l"}},
        {"default", "none"},
        {"title", "Colours by quality"},
        {"description",
         "Takes the place of the vertices' colours: from dark violet at 0 to yellow at the greatest possible value."}}},
      {"min_wall", min_wall_property()}};
}

bool asks_for_simplifying(const Json& parameters) { return parameters.at("simplify").is_number(); }

Status finish(Reconstruction& result, const Json& parameters, Context& context) {
  if (const double fraction = parameters.at("drop_parts"); fraction > 0) {
    const std::size_t before = result.mesh.triangles.size();
    drop_small_parts(result, fraction);
    note(result, "drop_parts", before);
  }
  compact(result.mesh);
  if (asks_for_simplifying(parameters)) {
    if (Status status = simplify(result, parameters.at("simplify"), context); !status) return status;
  }
  if (const Json& map = parameters.at("color_map"); map != "none") color_by_quality(result.mesh, map);
  sort_triangles(result.mesh);
  return Done{};
}

Json printing_json(const TriangleMesh& mesh, const Json& volume, const Json& parameters,
                   std::optional<MeshFormat> format, std::vector<std::string>& warnings) {
  Json walls = nullptr;
  const std::optional<double> limit = thinnest_wall(parameters, format);
  if (limit && !volume.is_null() && volume > 0) walls = walls_json(mesh, *limit, parameters.at("unit"), warnings);
  return Json{{"unit", parameters.at("unit")},
              {"bounding_box", bounds_of(mesh.positions).high - bounds_of(mesh.positions).low},
              {"volume", volume},
              {"walls", std::move(walls)}};
}

}  // namespace surfaced
