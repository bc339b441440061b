#include "reconstruction/report.hpp"

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

}  // namespace

Json cloud_json(const PointCloud& cloud) {
  const Bounds bounds = bounds_of(cloud.positions);
  return Json{{"points", cloud.input_to_vertex.size()},
              {"distinct_points", cloud.size()},
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

Json stages_json(const std::vector<Stage>& stages) {
  Json list = Json::array();
  for (const Stage& stage : stages) list.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  return list;
}

}  // namespace surfaced
