// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3 (Gong et al. 2014), section 2: theorems 1 to 3 and corollary 1, with the premise that the corollary
// leaves out, min edge >= epsilon / 2.
#include "intrinsic_delaunay/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>

#include "base/vectors.hpp"
#include "cloud/cloud.hpp"
#include "intrinsic_delaunay/close_sheets.hpp"
#include "intrinsic_delaunay/curvature.hpp"
#include "intrinsic_delaunay/flips.hpp"
#include "mesh/area_normal.hpp"
#include "quality/quality.hpp"

namespace surfaced {
namespace idt {
namespace {

/// κε at the largest ε that the theorem takes.
constexpr double kLargestKappaEpsilon = 0.125;

/// The mesh with vertices at one place made one; only those that triangles use. Triangle t stays triangle t.
struct Welded {
  std::vector<Point3> positions;
  std::vector<Triangle> triangles;
  /// The first vertex of the mesh that became this one.
  std::vector<VertexIndex> original;
  /// Any two did.
  bool joined = false;
};

Result<Welded> weld(const TriangleMesh& mesh, unsigned threads) {
  constexpr std::uint32_t kUnused = VertexIndex::kNone;
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  std::vector<VertexIndex> used;
  RawCloud raw;
  for (const Triangle& t : mesh.triangles) {
    for (const VertexIndex v : t) {
      if (number[v] != kUnused) continue;
      number[v] = static_cast<std::uint32_t>(used.size());
      used.push_back(v);
      raw.positions.push_back(mesh.positions[v]);
    }
  }
  Result<PointCloud> cloud = make_cloud(std::move(raw), threads);
  if (!cloud) return std::move(cloud).error();
  Welded welded;
  welded.original.resize(cloud->size());
  welded.joined = cloud->size() < used.size();
  for (std::size_t i = used.size(); i-- > 0;) welded.original[cloud->input_to_vertex[i]] = used[i];
  welded.triangles = mesh.triangles;
  for (Triangle& t : welded.triangles) {
    for (VertexIndex& v : t) v = cloud->input_to_vertex[number[v]];
  }
  welded.positions = std::move(cloud->positions);
  return welded;
}

QualityBounds bounds_for(double kappa_epsilon) {
  const double k2 = kappa_epsilon * kappa_epsilon;
  const double share = std::max(0.0, 1 - k2 / 24);
  return {
      .shortest_edge_to_circumradius = {.lower = std::max(0.0, 0.5 - k2 / 48), .upper = kMaxShortestEdgeToCircumradius},
      .inradius_to_longest_edge = {.lower = share * share / 48, .upper = kMaxInradiusToLongestEdge}};
}

/// By how much, as a share of the bound, the ratio lies below it; 1 for no area, and at most 0 inside.
double shortfall(const TriangleShape& shape, const QualityBounds& b) {
  const auto below = [](double ratio, const RatioBounds& r) { return r.lower > 0 ? 1 - ratio / r.lower : 0; };
  if (!(shape.area > 0)) return 1;
  return std::max(below(shape.shortest_edge_to_circumradius, b.shortest_edge_to_circumradius),
                  below(shape.inradius_to_longest_edge, b.inradius_to_longest_edge));
}

void count_violations(const TriangleShape& shape, QualityBounds& b) {
  const auto outside = [&](double ratio, const RatioBounds& r) {
    return !(shape.area > 0) || ratio < r.lower || ratio > r.upper;
  };
  if (outside(shape.shortest_edge_to_circumradius, b.shortest_edge_to_circumradius))
    ++b.shortest_edge_to_circumradius.violations;
  if (outside(shape.inradius_to_longest_edge, b.inradius_to_longest_edge)) ++b.inradius_to_longest_edge.violations;
}

void estimate_curvature(const Welded& mesh, std::span<const Point3> normals, const Adjacency& adjacency,
                        Context& context, Certificate& c) {
  std::vector<double> all = curvatures(mesh.positions, normals, adjacency, context);
  c.vertices_without_curvature = std::erase_if(all, [](double k) { return k < 0; });
  if (all.empty()) return;
  constexpr double kShare = 0.99;
  const auto rank = static_cast<std::size_t>(std::ceil(kShare * static_cast<double>(all.size()))) - 1;
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(rank));
  c.curvature_p99 = all[rank];
  c.largest_curvature = std::ranges::max(all);
}

double circumradius(const Point3& a, const Point3& b, const Point3& c, double area) {
  return norm(b - a) * norm(c - b) * norm(a - c) / (4 * area);
}

void measure_triangles(const Welded& mesh, Certificate& c) {
  c.shortest_edge = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles) {
    const Point3& p = mesh.positions[t[0]];
    const Point3& q = mesh.positions[t[1]];
    const Point3& r = mesh.positions[t[2]];
    c.shortest_edge = std::min({c.shortest_edge, norm(q - p), norm(r - q), norm(p - r)});
    const double area = shape_of(p, q, r).area;
    if (area > 0) c.epsilon = std::max(c.epsilon, circumradius(p, q, r, area));
  }
}

/// Edges at which angles add up to more than π, and whether all edges have two triangles.
void judge_edges(const TriangleMesh& unwelded, const Welded& mesh, Certificate& c) {
  const HalfEdges edges(mesh.triangles, mesh.positions.size());
  const auto corner = [&](HalfEdgeIndex h) { return mesh.positions[mesh.triangles[h / 3][h % 3]]; };
  for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
    const HalfEdgeIndex h(i);
    const HalfEdgeIndex mate = edges.mate(h);
    if (!mate.valid() || mate < h) continue;
    const Point3 left = corner(HalfEdges::previous(h));
    const Point3 right = corner(HalfEdges::previous(mate));
    if (angles_exceed_pi(corner(h), corner(mate), left, right)) ++c.edges_beyond_pi;
  }
  bool closed = true;
  for (std::size_t e = 0; e < edges.edges(); ++e) closed = closed && edges.uses(e) == 2;
  if (mesh.joined) closed = topology_of(unwelded).closed;
  c.without_boundary = closed ? Premise::holds : Premise::fails;
}

void judge_premises(Certificate& c) {
  const auto premise = [](bool holds) { return holds ? Premise::holds : Premise::fails; };
  if (c.largest_curvature > 0) c.largest_epsilon = kLargestKappaEpsilon / c.largest_curvature;
  c.epsilon_within_curvature = premise(!c.largest_epsilon || c.epsilon <= *c.largest_epsilon);
  c.edges_long_enough = premise(c.shortest_edge >= c.epsilon / 2);
  if (!(c.largest_curvature > 0)) return;
  c.injectivity_radius = std::numbers::pi / c.largest_curvature;
  c.convexity_radius = *c.injectivity_radius / 2;
  if (c.epsilon > *c.convexity_radius) {
    c.injectivity_and_convexity = Premise::fails;
  } else if (c.vertices_without_curvature == 0) {
    c.injectivity_and_convexity = Premise::estimated;
  }
}

void judge_triangles(const Welded& mesh, Certificate& c) {
  constexpr std::size_t kMostListed = 100;
  std::vector<std::pair<double, std::size_t>> outside;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const TriangleShape shape =
        shape_of(mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]]);
    count_violations(shape, c.bounds);
    count_violations(shape, c.bounds_at_largest_epsilon);
    const double farthest = std::max(shortfall(shape, c.bounds), shortfall(shape, c.bounds_at_largest_epsilon));
    if (farthest > 0) outside.emplace_back(-farthest, t);
  }
  const std::size_t listed = std::min(outside.size(), kMostListed);
  std::partial_sort(outside.begin(), outside.begin() + static_cast<std::ptrdiff_t>(listed), outside.end());
  for (std::size_t i = 0; i < listed; ++i) c.worst_triangles.emplace_back(outside[i].second);
}

Result<Certificate> certificate_of(const TriangleMesh& mesh, Context& context) {
  const Result<Welded> welded = weld(mesh, context.threads());
  if (!welded) return welded.error();
  const Adjacency adjacency = adjacency_of(welded->triangles, welded->positions.size());
  Certificate c;
  std::vector<Point3> normals = area_normals_at_vertices(welded->positions, welded->triangles);
  for (Point3& n : normals) n = direction_of(n).value_or(Point3{});
  estimate_curvature(*welded, normals, adjacency, context, c);
  if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while curvatures were estimated"};
  measure_triangles(*welded, c);
  judge_edges(mesh, *welded, c);
  judge_premises(c);
  // Where the surface turns within ε anyway, nothing follows from far pairs.
  constexpr std::size_t kAlways = 3'000'000;
  const std::size_t most_steps = std::max(kAlways, (c.bounds_apply() ? 1000U : 20U) * welded->positions.size());
  if (const auto pair = close_sheets(welded->positions, normals, adjacency, c.epsilon, most_steps)) {
    c.injectivity_and_convexity = Premise::fails;
    c.close_sheets = {welded->original[(*pair)[0]], welded->original[(*pair)[1]]};
  }
  c.bounds = bounds_for(c.largest_curvature * c.epsilon);
  c.bounds_at_largest_epsilon = bounds_for(kLargestKappaEpsilon);
  judge_triangles(*welded, c);
  c.hausdorff_bound = 4 * c.largest_curvature * c.epsilon * c.epsilon;
  c.normal_bound = 9 * c.largest_curvature * c.epsilon;
  return c;
}

}  // namespace
}  // namespace idt

Premise Certificate::premises_met() const {
  const std::array all{epsilon_within_curvature, edges_long_enough, without_boundary, injectivity_and_convexity};
  if (std::ranges::find(all, Premise::fails) != all.end()) return Premise::fails;
  return injectivity_and_convexity;
}

Result<Certificate> certify(const TriangleMesh& mesh, Context& context) {
  const std::string triangles = std::to_string(mesh.triangles.size()) + " triangles";
  if (mesh.triangles.empty()) return Error{ErrorCode::method_failed, "a mesh without triangles has no certificate"};
  try {
    return idt::certificate_of(mesh, context);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left to certify " + triangles};
  }
}

}  // namespace surfaced
