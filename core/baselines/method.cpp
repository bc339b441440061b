// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/method.hpp"

#include <algorithm>
#include <numeric>

#include "preparing/preparing.hpp"

namespace surfaced::baselines {

Status check_points(const PointCloud& cloud, std::size_t fewest, const char* method) {
  if (cloud.size() >= fewest) return Done{};
  return Error{ErrorCode::too_few_points, std::to_string(cloud.size()) + " distinct points of " +
                                              std::to_string(cloud.input_to_vertex.size()) + " remain; " + method +
                                              " needs " + std::to_string(fewest)};
}

void carry_attributes(const PointCloud& cloud, TriangleMesh& mesh, unsigned threads) {
  if (cloud.normals.empty() && cloud.colors.empty()) return;
  const std::vector<VertexIndex> nearest = nearest_points(cloud.positions, mesh.positions, threads).index;
  for (const VertexIndex v : nearest) {
    if (!cloud.normals.empty()) mesh.normals.push_back(cloud.normals[v]);
    if (!cloud.colors.empty()) mesh.colors.push_back(cloud.colors[v]);
  }
}

void sort_mesh(TriangleMesh& mesh) {
  std::vector<bool> used(mesh.positions.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const VertexIndex v : t) used[v] = true;
  }
  std::vector<std::size_t> order;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v]) order.push_back(v);
  }
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return mesh.positions[a] < mesh.positions[b]; });
  std::vector<VertexIndex> renumbered(mesh.positions.size());
  std::vector<Point3> positions;
  positions.reserve(order.size());
  for (const std::size_t v : order) {
    renumbered[v] = VertexIndex(positions.size());
    positions.push_back(mesh.positions[v]);
  }
  mesh.positions = std::move(positions);
  for (Triangle& t : mesh.triangles) {
    for (VertexIndex& v : t) v = renumbered[v];
  }
  sort_triangles(mesh);
}

namespace {

/// Triangles in other fans than the largest (then the first) of each vertex.
std::vector<bool> pinched(const TriangleMesh& mesh) {
  UnionFind fans = fans_of_corners(mesh);
  std::vector<std::uint32_t> size(3 * mesh.triangles.size(), 0);
  for (std::size_t c = 0; c < size.size(); ++c) ++size[fans.find(c)];
  std::vector<std::uint32_t> largest(mesh.positions.size(), VertexIndex::kNone);
  for (std::size_t c = 0; c < size.size(); ++c) {
    std::uint32_t& best = largest[mesh.triangles[c / 3].at(c % 3)];
    const std::uint32_t fan = fans.find(c);
    if (best == VertexIndex::kNone || size[fan] > size[best]) best = fan;
  }
  std::vector<bool> drop(mesh.triangles.size(), false);
  for (std::size_t c = 0; c < size.size(); ++c) {
    if (fans.find(c) != largest[mesh.triangles[c / 3].at(c % 3)]) drop[c / 3] = true;
  }
  return drop;
}

}  // namespace

void drop_pinched_fans(TriangleMesh& mesh) {
  for (;;) {
    const std::vector<bool> drop = pinched(mesh);
    if (std::ranges::find(drop, true) == drop.end()) return;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < drop.size(); ++t) {
      if (!drop[t]) mesh.triangles[kept++] = mesh.triangles[t];
    }
    mesh.triangles.resize(kept);
  }
}

}  // namespace surfaced::baselines
