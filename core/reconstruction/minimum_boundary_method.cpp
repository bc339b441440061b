// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "minimum_boundary/minimum_boundary.hpp"
#include "reconstruction/methods.hpp"

namespace surfaced {
namespace {

using Parameters = MinimumBoundaryParameters;

Parameters parameters_of(const Json& json) {
  Parameters parameters;
  if (json.at("components") == "one") parameters.components = Parameters::Components::one;
  if (json.at("components") == "many") parameters.components = Parameters::Components::many;
  if (json.at("lids") == "none") parameters.lids = Parameters::Lids::none;
  if (json.at("lids") == "ball") parameters.lids = Parameters::Lids::ball;
  if (json.at("lids") == "paper") parameters.lids = Parameters::Lids::paper;
  if (json.at("lids") == "mincut") parameters.lids = Parameters::Lids::mincut;
  if (json.at("delta").is_number()) parameters.delta = json.at("delta").get<double>();
  if (json.at("variant") == "paper") parameters.variant = Parameters::Variant::paper;
  if (json.at("variant") == "fast") parameters.variant = Parameters::Variant::fast;
  if (json.at("diagonals") == "shortest") parameters.diagonals = Parameters::Diagonals::shortest;
  if (json.at("openings") == "keep") parameters.openings = Parameters::Openings::keep;
  if (json.at("stop_after") == "boundary-complex") parameters.stop_after = Parameters::StopAfter::boundary_complex;
  if (json.at("stop_after") == "inflated") parameters.stop_after = Parameters::StopAfter::inflated;
  return parameters;
}

Json candidates_json(const MinimumBoundaryStatistics& s) {
  Json list = Json::array();
  for (const MinimumBoundaryCandidate& c : s.candidates) {
    list.push_back(Json{{"name", c.name},
                        {"chosen", c.name == s.chosen_candidate},
                        {"components", c.components},
                        {"genus", c.genus},
                        {"interior_vertices", c.interior_vertices},
                        {"sum_of_longest_edges", c.sum_lambda}});
  }
  return list;
}

Json sampling_json(const MinimumBoundaryStatistics& s) {
  if (!s.sampling) return nullptr;
  return Json{
      {"median", s.sampling->median}, {"high", s.sampling->high}, {"share_above_one", s.sampling->share_above_one}};
}

Json evidence_json(const MinimumBoundaryStatistics& s) {
  if (!s.evidence) return nullptr;
  const MinimumBoundaryEvidence& e = *s.evidence;
  return Json{{"candidates_agreeing", e.candidates_agreeing},
              {"more_handles", e.more_handles},
              {"fewer_handles", e.fewer_handles},
              {"gap", std::isfinite(e.gap) ? Json(e.gap) : Json(nullptr)},
              {"volume_gap", std::isfinite(e.volume_gap) ? Json(e.volume_gap) : Json(nullptr)},
              {"guided_agrees", e.guided_agrees},
              {"guide_agrees", e.guide_agrees},
              {"guide_open_edges", e.guide_open_edges},
              {"guide_unused_points", e.guide_unused},
              {"guide_shared", e.guide_shared},
              {"opposed_triangles", e.opposed_triangles}};
}

Json statistics_json(const MinimumBoundaryStatistics& s) {
  return Json{{"delaunay_cells", s.cells},
              {"boundary_complex_facets", s.boundary_complex_facets},
              {"reinserted_facets", s.reinserted_facets},
              {"conforming_cells", s.conforming_cells},
              {"artifacts", s.artifacts},
              {"hull_holes", s.hull_holes},
              {"lids", s.lids},
              {"delta", s.delta},
              {"seed_factor", s.seed_factor},
              {"inflated_cells", s.inflated_cells},
              {"exposed_vertices", s.exposed_vertices},
              {"flipped_edges", s.flipped_edges},
              {"candidates", candidates_json(s)},
              {"fused_regions", s.fused_regions},
              {"topology_margin", s.topology_margin ? Json(*s.topology_margin) : Json(nullptr)},
              {"handles_removed", s.removed_handles},
              {"interior_vertices", s.interior_vertices},
              {"components", s.components},
              {"genus", s.genus},
              {"bodies_seen", s.bodies_seen},
              {"bodies", s.bodies},
              {"bridges", s.bridges},
              {"sheet_area_share", s.sheet_area_share},
              {"opened_triangles", s.opened_triangles},
              {"joined_parts", s.joined_parts},
              {"thin_vertices", s.thin_vertices},
              {"buried_vertices", s.buried_vertices},
              {"outliers", s.outliers},
              {"sampling", sampling_json(s)},
              {"evidence", evidence_json(s)},
              {"doubt", s.doubt ? Json(*s.doubt) : Json(nullptr)},
              {"straightened_edges", s.straightened_edges},
              {"curvature_reduction", s.curvature_reduction ? Json(*s.curvature_reduction) : Json(nullptr)},
              {"sum_of_longest_edges", s.sum_lambda}};
}

Result<Reconstruction> run_minimum_boundary(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<MinimumBoundaryResult> result = minimum_boundary(cloud, parameters_of(parameters), context);
  if (!result) return std::move(result).error();
  return Reconstruction{.mesh = std::move(result->mesh),
                        .warnings = std::move(result->warnings),
                        .statistics = statistics_json(result->statistics)};
}

Json parameter_properties() {
  return Json{
      {"components",
       {{"enum", {"auto", "one", "many"}},
        {"default", "auto"},
        {"title", "Connectedness"},
        {"description",
         "one asks for a single surface; many drops the paper's connectedness condition; auto asks for as many as the "
         "points show closed bodies that only a bridge would join (variant=best with lids=watershed; else one)."}}},
      {"lids",
       {{"enum", {"watershed", "ball", "paper", "mincut", "none"}},
        {"default", "watershed"},
        {"title", "How holes in the hull of the boundary complex are covered"},
        {"description",
         "watershed merges the Delaunay cells that lie on the same side, highest overlap of their balls first, "
         "guarded by the boundary complex; ball adds all facets of low overlap; paper adds the facets between "
         "the vertices of artifacts with hull holes; mincut adds the facets of least total length that part large "
         "balls from the outside, for scans with wide openings; none covers nothing. With variant=paper, "
         "watershed stands for paper."}}},
      {"delta",
       {{"oneOf", {Json{{"const", "auto"}}, Json{{"type", "number"}, {"minimum", 0}, {"maximum", 2}}}},
        {"default", "auto"},
        {"title", "Overlap below which lids=ball covers and lids=mincut seeks its seeds"},
        {"description",
         "Ball ratio (r0 + r1 - distance) / min(r0, r1); auto tries a ladder of values and keeps "
         "what loses the fewest points."},
        {"x-unit", "1"}}},
      {"variant",
       {{"enum", {"best", "fast", "paper"}},
        {"default", "best"},
        {"title", "Effort"},
        {"description",
         "best compares several labellings and keeps the best parts of each; fast makes one; paper takes the "
         "steps of the paper: conforming, hole covering, inflating, sculpturing."}}},
      {"diagonals",
       {{"enum", {"straight", "shortest"}},
        {"default", "straight"},
        {"title", "Edges flipped in the end"},
        {"description",
         "With variant=best: straight flips edges where that lowers the absolute mean curvature, so that sharp edges "
         "keep no notches; shortest keeps the least sum of longest edges that was found."}}},
      {"openings",
       {{"enum", {"close", "keep"}},
        {"default", "close"},
        {"title", "What becomes of openings"},
        {"description",
         "close spans them; keep cuts out the triangles more than ten times as wide as the points at their corners lie "
         "apart: the mesh is then manifold with a boundary."}}},
      {"stop_after",
       {{"enum", {"none", "boundary-complex", "inflated"}},
        {"default", "none"},
        {"title", "Stage to stop after"},
        {"description",
         "boundary-complex gives BC_0 for display, which is not manifold; inflated the closed surface "
         "before its last improvement."}}}};
}

}  // namespace

Method minimum_boundary_method() {
  return {
      .info = {.id = "minimum-boundary",
               .title = "Minimum boundary",
               .summary =
                   "Connects the points by the closed surface of the Delaunay triangulation whose triangles have "
                   "the shortest longest edges. For sparse and uneven clouds of closed objects.",
               .source = "S. Ohrhallinger, S. Mudur, M. Wimmer, Minimizing edge length to connect sparsely sampled "
                         "unstructured point sets, Computers & Graphics 37 (2013)",
               .guarantees = {"The mesh is closed unless openings=keep, oriented outwards, edge- and vertex-manifold.",
                              "It does not intersect itself, in the coordinates computed with.",
                              "Every vertex is an input point, and every input point is a vertex or inside the mesh."},
               .limitations = {"The genus is not guaranteed.", "Openings of a scan are closed unless openings=keep.",
                               "All points in one plane are refused: no closed surface exists."},
               .parameters = schema_of(parameter_properties())},
      .interpolates = true,
      .of_a_point = {.seconds = 80e-6, .bytes = 4 << 10},
      .engine = run_minimum_boundary};
}

}  // namespace surfaced
