// SPDX-License-Identifier: GPL-3.0-or-later
// Estimation by planes and jets as in CGAL's pca_estimate_normals and jet_estimate_normals, which take any
// neighbourhood for one that fits. Orientation after H. Hoppe, T. DeRose, T.
// Duchamp, J. McDonald, W. Stuetzle, "Surface reconstruction from unorganized points", SIGGRAPH 1992: along a minimum
// spanning forest of the neighbours, cheap where normals agree. By hand, because CGAL's mst_orient_normals orients one
// connected part only and cannot be stopped (docs/DECISIONS.md).
#include <algorithm>
#include <optional>
#include <tuple>

#include "base/sided_sets.hpp"
#include "base/vectors.hpp"
#include "fitting/fitting.hpp"
#include "preparing/library_neighbours.hpp"
#include "preparing/neighbourhood.hpp"
#include "preparing/stage.hpp"

namespace surfaced {
namespace {

constexpr double kEstimatedUntil = 0.7;

std::optional<Point3> normal_of_jet(std::span<const Point3> near) {
  const auto jet = jet_of(near, JetForm::normal);
  return jet ? std::optional(jet->normal) : std::nullopt;
}

/// Neighbours that fit no quadric get the normal of the plane that fits them best, if there is one.
std::vector<Point3> estimated(const PointCloud& cloud, NormalFit fit, std::size_t neighbours, Context& context) {
  const std::vector<Point3> points = preparing::local_points(cloud, LocalFrame(cloud.positions));
  std::vector<Point3> normals(points.size(), Point3{0, 0, 1});
  preparing::each_neighbourhood(points, neighbours, kEstimatedUntil, context,
                                [&](std::size_t v, std::span<const Point3> near) {
                                  std::optional<Point3> normal;
                                  if (fit == NormalFit::jet) normal = normal_of_jet(near);
                                  if (!normal) normal = normal_of_plane(near);
                                  if (normal) normals[v] = *normal;
                                });
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
