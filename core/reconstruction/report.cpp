// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/report.hpp"

#include "reconstruction/words.hpp"

namespace surfaced {
namespace {

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json distribution_json(const std::optional<Distribution>& d) {
  if (!d) return nullptr;
  return Json{{"min", d->min},
              {"max", d->max},
              {"mean", d->mean},
              {"p05", d->p05},
              {"p50", d->p50},
              {"p95", d->p95},
              {"histogram", {{"lower", 0.0}, {"upper", d->upper}, {"counts", d->histogram}}}};
}

Json premise_json(Premise premise) {
  if (premise == Premise::estimated) return "estimated";
  if (premise == Premise::assumed) return "assumed";
  return premise == Premise::holds;
}

Json ratio_bounds_json(const RatioBounds& b) {
  return Json{{"lower", b.lower}, {"upper", b.upper}, {"violations", b.violations}};
}

Json bounds_json(const QualityBounds& b) {
  return Json{{"shortest_edge_to_circumradius", ratio_bounds_json(b.shortest_edge_to_circumradius)},
              {"inradius_to_longest_edge", ratio_bounds_json(b.inradius_to_longest_edge)}};
}

Json premises_json(const Certificate& c) {
  Json sheets = nullptr;
  if (c.close_sheets) sheets = Json::array({(*c.close_sheets)[0].value, (*c.close_sheets)[1].value});
  return Json{
      {"epsilon_within_curvature",
       {{"met", premise_json(c.epsilon_within_curvature)},
        {"epsilon", c.epsilon},
        {"limit", or_null(c.largest_epsilon)}}},
      {"edges_long_enough",
       {{"met", premise_json(c.edges_long_enough)}, {"shortest_edge", c.shortest_edge}, {"limit", c.epsilon / 2}}},
      {"without_boundary", {{"met", premise_json(c.without_boundary)}}},
      {"injectivity_and_convexity",
       {{"met", premise_json(c.injectivity_and_convexity)},
        {"injectivity_radius", or_null(c.injectivity_radius)},
        {"convexity_radius", or_null(c.convexity_radius)},
        {"close_sheets", std::move(sheets)}}}};
}

std::string why_bounds_say_nothing(const Certificate& c) {
  return "epsilon is " + briefly(c.epsilon * c.largest_curvature) +
         " / kappa, and the theorem takes 1/8 at most; beyond, its formulas fall to 0 and prove nothing";
}

Json table_json(const std::optional<TableFacts>& table) {
  if (!table) return nullptr;
  return Json{{"columns", table->columns},
              {"separator", table->separator},
              {"decimal", table->decimal},
              {"skipped_lines", table->skipped},
              {"guessed", table->guessed}};
}

}  // namespace

Json cloud_json(const PointCloud& cloud) {
  const Bounds bounds = bounds_of(cloud.positions);
  return Json{{"points", cloud.input_to_vertex.size()},
              {"distinct_points", cloud.size()},
              {"missing_points", cloud.missing},
              {"format", cloud.source.format},
              {"faces", cloud.source.faces},
              {"table", table_json(cloud.source.table)},
              {"has_normals", !cloud.normals.empty()},
              {"has_colors", !cloud.colors.empty()},
              {"bounds", {{"min", bounds.low}, {"max", bounds.high}}}};
}

Json topology_json(const Topology& t) {
  return Json{{"vertices", t.vertices},
              {"triangles", t.triangles},
              {"edges", t.edges},
              {"closed", t.closed},
              {"edge_manifold", t.edge_manifold},
              {"vertex_manifold", t.vertex_manifold},
              {"oriented", t.oriented},
              {"components", t.components},
              {"euler_characteristic", t.euler_characteristic},
              {"genus", or_null(t.genus)},
              {"boundary_loops", t.boundary_loops},
              {"boundary_edges", t.boundary_edges},
              {"non_manifold_edges", t.non_manifold_edges},
              {"non_manifold_vertices", t.non_manifold_vertices}};
}

Json quality_json(const MeshQuality& quality, const std::optional<PointUse>& use,
                  const std::optional<std::size_t>& self_intersections) {
  return Json{{"shortest_edge_to_circumradius", distribution_json(quality.shortest_edge_to_circumradius)},
              {"inradius_to_longest_edge", distribution_json(quality.inradius_to_longest_edge)},
              {"degenerate_triangles", quality.degenerate_triangles},
              {"unused_points", use ? Json(use->unused) : Json(nullptr)},
              {"interior_vertices", use ? or_null(use->interior) : Json(nullptr)},
              {"area", quality.area},
              {"volume", or_null(quality.volume)},
              {"longest_edge_sum", quality.longest_edge_sum},
              {"self_intersections", or_null(self_intersections)}};
}

Json certificate_json(const Certificate& c) {
  Json worst = Json::array();
  for (const TriangleIndex t : c.worst_triangles) worst.push_back(t.value);
  return Json{
      {"curvature",
       {{"max", c.largest_curvature}, {"p99", c.curvature_p99}, {"vertices_without", c.vertices_without_curvature}}},
      {"epsilon", c.epsilon},
      {"edges_beyond_pi", c.edges_beyond_pi},
      {"premises", premises_json(c)},
      {"premises_met", premise_json(c.premises_met())},
      {"bounds", bounds_json(c.bounds)},
      {"bounds_met", c.bounds_apply() ? Json(c.bounds.met()) : Json(nullptr)},
      {"bounds_say_nothing_because", c.bounds_apply() ? Json(nullptr) : Json(why_bounds_say_nothing(c))},
      {"bounds_at_largest_epsilon", bounds_json(c.bounds_at_largest_epsilon)},
      {"bounds_at_largest_epsilon_met", c.bounds_at_largest_epsilon.met()},
      {"worst_triangles", std::move(worst)},
      {"hausdorff_bound", c.hausdorff_bound},
      {"normal_bound", c.normal_bound}};
}

std::vector<std::string> certificate_warnings(const Certificate& c) {
  if (!c.close_sheets) return {};
  const auto& [a, b] = *c.close_sheets;
  return {"sheets of the surface may be too close for the sampling: vertices " + std::to_string(a.value) + " and " +
          std::to_string(b.value) + " face away from each other within 2 epsilon, far from each other on the mesh"};
}

Json stages_json(const std::vector<Stage>& stages) {
  Json list = Json::array();
  for (const Stage& stage : stages) list.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  return list;
}

}  // namespace surfaced
