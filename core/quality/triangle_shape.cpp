// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "quality/quality.hpp"

namespace surfaced {
namespace {

/// Percentile by nearest rank; reorders the values.
double nearest_rank(std::vector<double>& values, double fraction) {
  const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, values.size()) - 1);
  std::ranges::nth_element(values, at);
  return *at;
}

Distribution distribution_of(std::vector<double> values, double upper) {
  Distribution d;
  d.upper = upper;
  for (const double x : values) {
    d.mean += x;
    const auto bin = static_cast<std::size_t>(x / upper * static_cast<double>(Distribution::kBins));
    ++d.histogram[std::min(bin, Distribution::kBins - 1)];
  }
  d.mean /= static_cast<double>(values.size());
  const auto [least, greatest] = std::ranges::minmax(values);
  d.min = least;
  d.max = greatest;
  d.p05 = nearest_rank(values, 0.05);
  d.p50 = nearest_rank(values, 0.50);
  d.p95 = nearest_rank(values, 0.95);
  return d;
}

double longest_edge(const Point3& a, const Point3& b, const Point3& c) {
  return std::max({norm(b - a), norm(c - b), norm(a - c)});
}

}  // namespace

TriangleShape shape_of(const Point3& a, const Point3& b, const Point3& c) {
  struct Edge {
    Point3 vector;
    double length;
  };
  std::array<Edge, 3> edges{Edge{b - a, norm(b - a)}, Edge{c - b, norm(c - b)}, Edge{a - c, norm(a - c)}};
  std::ranges::sort(edges, {}, &Edge::length);
  const double doubled_area = norm(cross(edges[0].vector, edges[1].vector));
  if (!(doubled_area > 0)) return {};
  const double middle = edges[1].length;
  const double longest = edges[2].length;
  const double perimeter = edges[0].length + middle + longest;
  return {
      .shortest_edge_to_circumradius = std::min(2 * doubled_area / (middle * longest), kMaxShortestEdgeToCircumradius),
      .inradius_to_longest_edge = std::min(doubled_area / (perimeter * longest), kMaxInradiusToLongestEdge),
      .area = doubled_area / 2};
}

MeshQuality measure_quality(const TriangleMesh& mesh, const Topology& topology) {
  MeshQuality quality;
  std::vector<double> edge_ratios;
  std::vector<double> radius_ratios;
  edge_ratios.reserve(mesh.triangles.size());
  radius_ratios.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const Point3& a = mesh.positions[t[0]];
    const Point3& b = mesh.positions[t[1]];
    const Point3& c = mesh.positions[t[2]];
    const TriangleShape shape = shape_of(a, b, c);
    edge_ratios.push_back(shape.shortest_edge_to_circumradius);
    radius_ratios.push_back(shape.inradius_to_longest_edge);
    quality.area += shape.area;
    quality.longest_edge_sum += longest_edge(a, b, c);
    quality.degenerate_triangles += shape.area > 0 ? 0 : 1;
  }
  if (!mesh.triangles.empty()) {
    quality.shortest_edge_to_circumradius = distribution_of(std::move(edge_ratios), kMaxShortestEdgeToCircumradius);
    quality.inradius_to_longest_edge = distribution_of(std::move(radius_ratios), kMaxInradiusToLongestEdge);
  }
  if (topology.closed && topology.oriented) quality.volume = signed_volume(mesh);
  return quality;
}

VertexQuality vertex_quality(const TriangleMesh& mesh) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  VertexQuality quality{std::vector<float>(mesh.positions.size(), kNone),
                        std::vector<float>(mesh.positions.size(), kNone)};
  for (const Triangle& t : mesh.triangles) {
    const TriangleShape shape = shape_of(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    for (const VertexIndex v : t) {
      float& edges = quality.shortest_edge_to_circumradius[v];
      float& radii = quality.inradius_to_longest_edge[v];
      edges = std::min(edges, static_cast<float>(shape.shortest_edge_to_circumradius));
      radii = std::min(radii, static_cast<float>(shape.inradius_to_longest_edge));
    }
  }
  std::ranges::replace(quality.shortest_edge_to_circumradius, kNone, 0.0F);
  std::ranges::replace(quality.inradius_to_longest_edge, kNone, 0.0F);
  return quality;
}

}  // namespace surfaced
