// SPDX-License-Identifier: GPL-3.0-or-later
// Estimation by CGAL's pca_estimate_normals and jet_estimate_normals. Orientation after H. Hoppe, T. DeRose, T.
// Duchamp, J. McDonald, W. Stuetzle, "Surface reconstruction from unorganized points", SIGGRAPH 1992: along a minimum
// spanning forest of the neighbours, cheap where normals agree. By hand, because CGAL's mst_orient_normals orients one
// connected part only and cannot be stopped (docs/DECISIONS.md).
#define CGAL_EIGEN3_ENABLED
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/jet_estimate_normals.h>
#include <CGAL/pca_estimate_normals.h>

#include <algorithm>
#include <tuple>

#include "base/sided_sets.hpp"
#include "base/vectors.hpp"
#include "preparing/neighbourhood.hpp"
#include "preparing/stage.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PointVector = std::pair<Kernel::Point_3, Kernel::Vector_3>;

constexpr double kEstimatedUntil = 0.7;

std::vector<Point3> estimated(const PointCloud& cloud, NormalFit fit, std::size_t neighbours, Context& context) {
  const LocalFrame frame(cloud.positions);
  std::vector<PointVector> points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) {
    const Point3 local = frame.to_local(p);
    points.emplace_back(Kernel::Point_3(local[0], local[1], local[2]), CGAL::NULL_VECTOR);
  }
  // A lambda, not a std::function: CGAL 5.5.1 would keep a reference to a copy of that which has ended.
  const auto parameters = CGAL::parameters::point_map(CGAL::First_of_pair_property_map<PointVector>())
                              .normal_map(CGAL::Second_of_pair_property_map<PointVector>())
                              .callback([&context](double done) {
                                context.report(kEstimatedUntil * done);
                                return !context.cancelled();
                              });
  const auto k = static_cast<unsigned>(neighbours);
  if (fit == NormalFit::jet) {
    CGAL::jet_estimate_normals<CGAL::Sequential_tag>(points, k, parameters);
  } else {
    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, k, parameters);
  }
  std::vector<Point3> normals;
  normals.reserve(points.size());
  for (const auto& [point, normal] : points) {
    // Neighbours that fit no plane better than another may give no direction.
    normals.push_back(direction_of({normal.x(), normal.y(), normal.z()}).value_or(Point3{0, 0, 1}));
  }
  return normals;
}

/// Neighbours a < b; cheap where their normals agree, up to the side.
struct Link {
  float cost;
  std::uint32_t a;
  std::uint32_t b;
  friend auto operator<=>(const Link&, const Link&) = default;
};

std::vector<Link> links_of(const std::vector<Point3>& positions, const std::vector<Point3>& normals,
                           std::size_t neighbours, unsigned threads) {
  const std::vector<std::uint32_t> table = preparing::neighbour_table(positions, neighbours, threads);
  std::vector<Link> links;
  links.reserve(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    const auto v = static_cast<std::uint32_t>(i / neighbours);
    if (table[i] == VertexIndex::kNone) continue;
    links.push_back({static_cast<float>(1 - std::abs(dot(normals[v], normals[table[i]]))), std::min(v, table[i]),
                     std::max(v, table[i])});
  }
  std::ranges::sort(links, [](const Link& x, const Link& y) { return x < y; });
  return links;
}

bool faces_up(const Point3& n) {
  if (n[2] != 0) return n[2] > 0;
  return n[1] != 0 ? n[1] > 0 : n[0] >= 0;
}

/// The highest point of every set decides which way its set faces.
void face_up(const std::vector<Point3>& positions, SidedSets& sets, std::vector<Point3>& normals) {
  const auto higher = [&](std::size_t a, std::size_t b) {
    const Point3& p = positions[a];
    const Point3& q = positions[b];
    return std::tie(p[2], p[1], p[0]) > std::tie(q[2], q[1], q[0]);
  };
  std::vector<std::uint32_t> top(positions.size(), VertexIndex::kNone);
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    std::uint32_t& best = top[sets.find(v) >> 1U];
    if (best == VertexIndex::kNone || higher(v, best)) best = v;
  }
  std::vector<bool> turn(positions.size());
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const std::uint32_t member = sets.find(v);
    const std::uint32_t best = top[member >> 1U];
    const bool against_best = ((member ^ sets.find(best)) & 1U) != 0;
    turn[v] = against_best == faces_up(normals[best]);
  }
  for (std::size_t v = 0; v < turn.size(); ++v) {
    if (turn[v]) normals[v] = {-normals[v][0], -normals[v][1], -normals[v][2]};
  }
}

void orient(const std::vector<Point3>& positions, std::vector<Point3>& normals, std::size_t neighbours,
            unsigned threads) {
  SidedSets sets(positions.size());
  for (const Link& link : links_of(positions, normals, neighbours, threads)) {
    sets.unite(link.a, link.b, dot(normals[link.a], normals[link.b]) < 0 ? 1 : 0);
  }
  face_up(positions, sets, normals);
}

}  // namespace

Result<PointCloud> with_normals(const PointCloud& cloud, NormalFit fit, std::size_t neighbours, Context& context) {
  // A jet of degree 2 has 6 coefficients.
  constexpr std::size_t kFewest = 7;
  return preparing::guarded<PointCloud>("the estimation of normals", context, [&]() -> Result<PointCloud> {
    const NormalFit possible = cloud.size() < kFewest ? NormalFit::plane : fit;
    if (cloud.size() < 3) {
      return Error{ErrorCode::too_few_points, std::to_string(cloud.size()) + " distinct points; normals need 3"};
    }
    const std::size_t k = std::min(neighbours, cloud.size() - 1);
    std::vector<Point3> normals = estimated(cloud, possible, k, context);
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled during the estimation of normals"};
    orient(cloud.positions, normals, k, context.threads());
    PointCloud result = cloud;
    result.normals.clear();
    for (const Point3& n : normals) {
      result.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
    }
    return result;
  });
}

}  // namespace surfaced
