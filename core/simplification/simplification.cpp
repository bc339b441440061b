// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplification/simplification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "base/float32.hpp"
#include "base/library_failure.hpp"
#include "base/vectors.hpp"
#include "quality/quality.hpp"
#include "simplification/collapse.hpp"

namespace surfaced {
namespace {

using simplification::Collapsed;
using simplification::Stop;

/// Gives every umbrella a vertex of its own; vertices that triangles leave out stay.
TriangleMesh with_umbrellas_apart(const TriangleMesh& mesh) {
  TriangleMesh apart = mesh;
  UnionFind corners = fans_of_corners(mesh);
  std::vector<bool> taken(mesh.positions.size(), false);
  std::vector<VertexIndex> vertex_of(corners.size());
  for (std::size_t h = 0; h < corners.size(); ++h) {
    VertexIndex& v = vertex_of[corners.find(h)];
    if (!v.valid()) {
      v = mesh.triangles[h / 3][h % 3];
      if (taken[v]) {
        apart.positions.push_back(mesh.positions[v]);
        if (!mesh.normals.empty()) apart.normals.push_back(mesh.normals[v]);
        if (!mesh.colors.empty()) apart.colors.push_back(mesh.colors[v]);
        v = VertexIndex(apart.positions.size() - 1);
      } else {
        taken[v] = true;
      }
    }
    apart.triangles[h / 3].at(h % 3) = v;
  }
  return apart;
}

/// Shares of the corners of a triangle in a point of it.
Point3 barycentric(const TriangleMesh& mesh, const Triangle& t, const Point3& p) {
  const Point3& a = mesh.positions[t[0]];
  const Point3 normal = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
  const double whole = dot(normal, normal);
  if (!(whole > 0)) return {1, 0, 0};
  const double second = std::clamp(dot(cross(p - a, mesh.positions[t[2]] - a), normal) / whole, 0.0, 1.0);
  const double third = std::clamp(dot(cross(mesh.positions[t[1]] - a, p - a), normal) / whole, 0.0, 1.0);
  return {std::max(0.0, 1 - second - third), second, third};
}

/// Normal and colour of a point of the surface, appended to those of the simplified mesh.
void append_attributes(TriangleMesh& target, const TriangleMesh& mesh, const Triangle& t, const Point3& shares) {
  if (!mesh.normals.empty()) {
    Point3 sum{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Normal3& n = mesh.normals[t[k]];
      sum += shares[k] * Point3{n[0], n[1], n[2]};
    }
    const std::optional<Point3> unit = direction_of(sum);
    const Normal3& first = mesh.normals[t[0]];
    target.normals.push_back(
        unit ? Normal3{static_cast<float>((*unit)[0]), static_cast<float>((*unit)[1]), static_cast<float>((*unit)[2])}
             : first);
  }
  if (!mesh.colors.empty()) {
    Color4& color = target.colors.emplace_back();
    for (std::size_t c = 0; c < color.size(); ++c) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += shares[k] * mesh.colors[t[k]][c];
      color.at(c) = static_cast<std::uint8_t>(std::clamp(std::round(sum), 0.0, 255.0));
    }
  }
}

void carry_attributes(Collapsed& collapsed, const TriangleMesh& mesh, const SurfaceSearch& search,
                      const Context& context) {
  constexpr std::size_t kVerticesBetweenChecks = 1024;
  TriangleMesh& target = collapsed.mesh;
  std::size_t hint = 0;
  for (std::size_t v = 0; v < target.positions.size(); ++v) {
    if (v % kVerticesBetweenChecks == 0) stop_if_cancelled(context);
    if (const VertexIndex same = collapsed.untouched[v]; same.valid()) {
      if (!mesh.normals.empty()) target.normals.push_back(mesh.normals[same]);
      if (!mesh.colors.empty()) target.colors.push_back(mesh.colors[same]);
      continue;
    }
    const SurfaceSearch::Closest closest = search.closest(target.positions[v], hint);
    hint = closest.place;
    const Triangle& t = mesh.triangles[closest.triangle];
    append_attributes(target, mesh, t, barycentric(mesh, t, closest.point));
  }
}

/// Vertices that were placed anew, where files hold them without loss.
void round_to_float32(Collapsed& collapsed) {
  for (std::size_t v = 0; v < collapsed.mesh.positions.size(); ++v) {
    if (collapsed.untouched[v].valid()) continue;
    for (double& x : collapsed.mesh.positions[v]) x = static_cast<double>(static_cast<float>(x));
  }
}

/// Simplifies one mesh, as often as it takes.
class Simplifier {
 public:
  Simplifier(const TriangleMesh& mesh, Context& context)
      : mesh_(with_umbrellas_apart(mesh)), search_(mesh_), narrow_(fits_float32(mesh.positions)), context_(context) {}

  Simplified run(const Stop& stop) const {
    Collapsed collapsed = simplification::collapse(mesh_, stop, context_);
    if (narrow_) round_to_float32(collapsed);
    if (!search_.empty()) carry_attributes(collapsed, mesh_, search_, context_);
    const SurfaceSearch simplified(collapsed.mesh);
    const double there = distance(collapsed.mesh, search_, kCollapsed, kThere);
    const double back = distance(mesh_, simplified, kThere, 1);
    return {.mesh = std::move(collapsed.mesh), .distance = std::max(there, back)};
  }

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  static constexpr double kCollapsed = simplification::kShareOfCollapses;
  static constexpr double kThere = (1 + kCollapsed) / 2;

  /// The upper bound, found while the progress goes from one share of the stage to the other.
  double distance(const TriangleMesh& from, const SurfaceSearch& to, double begin, double end) const {
    const auto go_on = [&](double done) {
      context_.report(begin + (end - begin) * done);
      return !context_.cancelled();
    };
    const std::optional<SurfaceDistance> found = surface_distance(from, to, context_.threads(), go_on);
    if (!found) throw Cancelled{};
    return found->upper;
  }

  TriangleMesh mesh_;
  SurfaceSearch search_;
  bool narrow_;
  Context& context_;
};

/// The quadric error says little about the distance, but both grow alike: each attempt learns from the one before.
Simplified attempt_within(const Simplifier& simplifier, double distance) {
  constexpr int kMostAttempts = 4;
  constexpr double kCloseEnough = 0.7;
  constexpr double kAim = 0.85;
  Simplified best{.mesh = simplifier.mesh()};
  double error = distance;
  double too_much = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    Simplified result = simplifier.run({.triangles = 0, .error = error});
    const double ratio = result.distance / distance;
    if (ratio <= 1 && result.mesh.triangles.size() < best.mesh.triangles.size()) best = std::move(result);
    if (ratio > 1) too_much = error;
    if (ratio >= kCloseEnough && ratio <= 1) break;
    const double next = error * std::clamp(kAim / std::max(ratio, 1e-3), 0.05, 8.0);
    error = next < too_much ? next : (error + too_much) / 2;
  }
  return best;
}

Status check_manifold(const Topology& topology) {
  if (topology.oriented && topology.edge_manifold) return Done{};
  return Error{ErrorCode::method_failed, "simplify takes oriented meshes whose edges have two triangles at most; " +
                                             std::to_string(topology.non_manifold_edges) + " of " +
                                             std::to_string(topology.edges) + " edges have more" +
                                             (topology.oriented ? "" : ", or neighbours face opposite sides")};
}

template <class Work>
Result<Simplified> guarded(const TriangleMesh& mesh, Work work) {
  try {
    if (Status fit = check_manifold(topology_of(mesh)); !fit) return std::move(fit).error();
    return work();
  } catch (const Cancelled&) {
    return Error{ErrorCode::cancelled, "cancelled while simplifying"};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "simplifying " + std::to_string(mesh.triangles.size()) + " triangles needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{ErrorCode::method_failed, "CGAL's edge collapse failed: " + reason_of(failure)};
  }
}

}  // namespace

Result<Simplified> simplified_to(const TriangleMesh& mesh, std::size_t triangles, Context& context) {
  return guarded(mesh, [&]() -> Result<Simplified> {
    if (mesh.triangles.size() <= triangles) return Simplified{.mesh = mesh};
    return Simplifier(mesh, context).run({.triangles = triangles, .error = std::numeric_limits<double>::infinity()});
  });
}

Result<Simplified> simplified_within(const TriangleMesh& mesh, double distance, Context& context) {
  return guarded(mesh, [&]() -> Result<Simplified> { return attempt_within(Simplifier(mesh, context), distance); });
}

}  // namespace surfaced
