// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/input_vertices.hpp"

#include <algorithm>
#include <utility>

namespace surfaced {

std::vector<VertexIndex> vertices_of_input(const PointCloud& cloud, const TriangleMesh& mesh) {
  std::vector<std::pair<Point3, VertexIndex>> vertices;
  vertices.reserve(mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) vertices.emplace_back(mesh.positions[v], VertexIndex(v));
  std::ranges::sort(vertices);
  std::vector<VertexIndex> of_point(cloud.size());
  for (std::size_t p = 0; p < cloud.size(); ++p) {
    const auto at = std::ranges::lower_bound(vertices, cloud.positions[p], {}, &std::pair<Point3, VertexIndex>::first);
    if (at != vertices.end() && at->first == cloud.positions[p]) of_point[p] = at->second;
  }
  std::vector<VertexIndex> of_input;
  of_input.reserve(cloud.input_to_vertex.size());
  for (const VertexIndex p : cloud.input_to_vertex) of_input.push_back(p.valid() ? of_point[p] : VertexIndex());
  return of_input;
}

}  // namespace surfaced
