// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <new>
#include <unordered_map>
#include <unordered_set>

#include "base/vectors.hpp"
#include "hole_filling/angle_front.hpp"
#include "hole_filling/boundary_loops.hpp"
#include "hole_filling/hole_filling.hpp"
#include "hole_filling/library_patch.hpp"
#include "hole_filling/refinement.hpp"

namespace surfaced {
namespace filling {
namespace {

/// Longest loop that is small.
constexpr std::size_t kSmall = 30;
/// Longest loops that the advancing front and the library are given; their cost grows faster than the hole.
constexpr std::size_t kLongestForAngles = 4000;
constexpr std::size_t kLongestForLibrary = 1000;
/// New points a hole may take, as a multiple of the mesh's vertices, and in any case.
constexpr std::size_t kMostGrowth = 4;
constexpr std::size_t kAlwaysAllowed = 10'000;
/// Share of its component's area above which a hole is no hole but the component's outside.
constexpr double kLargestShare = 0.5;

std::uint64_t key_of(VertexIndex a, VertexIndex b) {
  return (std::uint64_t{std::min(a, b).value} << 32U) | std::max(a, b).value;
}

class Filling {
 public:
  Filling(TriangleMesh& mesh, const FillParameters& parameters, Context& context)
      : mesh_(mesh), parameters_(parameters), context_(context) {}

  Result<FillReport> operator()() {
    const std::vector<BoundaryLoop> loops = boundary_loops(mesh_);
    report_.loops = loops.size();
    if (loops.empty()) return std::move(report_);
    survey(loops);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      if (context_.cancelled()) return Error{ErrorCode::cancelled, "cancelled while filling holes"};
      const BoundaryLoop& loop = loops[i];
      std::string reason = loop.obstacle.empty() ? fill(loop) : loop.obstacle;
      if (reason.empty()) {
        ++report_.filled;
      } else {
        report_.left.push_back({loop.corners.front(), loop.corners.size(), std::move(reason)});
      }
      context_.report(static_cast<double>(i + 1) / static_cast<double>(loops.size()));
    }
    return std::move(report_);
  }

 private:
  /// What is needed of the mesh around the loops: normals, edges between boundary vertices, areas of components.
  void survey(const std::vector<BoundaryLoop>& loops) {
    for (const BoundaryLoop& loop : loops) {
      for (const VertexIndex v : loop.corners) normals_.emplace(v.value, Point3{});
    }
    const Components components = components_of(mesh_);
    areas_.resize(components.count, 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Triangle& triangle = mesh_.triangles[t];
      const Point3 normal = area_vector(triangle);
      areas_[components.of_triangle[t]] += norm(normal) / 2;
      for (std::size_t i = 0; i < 3; ++i) survey_corner(triangle, i, normal, components.of_triangle[t]);
    }
  }

  void survey_corner(const Triangle& t, std::size_t i, const Point3& normal, std::uint32_t component) {
    const VertexIndex v = t[i];
    const VertexIndex next = t[(i + 1) % 3];
    const auto on_boundary = normals_.find(v.value);
    if (on_boundary == normals_.end()) return;
    component_of_[v.value] = component;
    if (normals_.contains(next.value)) edges_.insert(key_of(v, next));
    const Point3 a = mesh_.positions[next] - mesh_.positions[v];
    const Point3 b = mesh_.positions[t[(i + 2) % 3]] - mesh_.positions[v];
    if (const auto direction = direction_of(normal)) {
      on_boundary->second += std::atan2(norm(cross(a, b)), dot(a, b)) * *direction;
    }
  }

  Point3 area_vector(const Triangle& t) const {
    const Point3& a = mesh_.positions[t[0]];
    return cross(mesh_.positions[t[1]] - a, mesh_.positions[t[2]] - a);
  }

  /// @return  why it could not; empty once it is done.
  std::string fill(const BoundaryLoop& loop) {
    const Hole hole = hole_of(loop);
    if (parameters_.holes == FillParameters::Holes::small) return fill_small(loop, hole);
    if (std::string reason = too_large(loop, hole); !reason.empty()) return reason;
    const std::size_t most = std::max(kAlwaysAllowed, kMostGrowth * mesh_.positions.size());
    std::optional<Patch> patch;
    if (loop.corners.size() <= kLongestForAngles) patch = cover_by_angles(hole, most);
    if (!patch && loop.corners.size() <= kLongestForLibrary) {
      patch = cover_by_library(hole);
      if (patch) ++report_.filled_by_library;
    }
    if (!patch) {
      return "neither the advancing front (up to " + std::to_string(kLongestForAngles) +
             " edges) nor the library (up to " + std::to_string(kLongestForLibrary) + " edges) covers it";
    }
    refine(*patch, hole, parameters_.rotation);
    append(loop, *patch);
    return {};
  }

  Hole hole_of(const BoundaryLoop& loop) const {
    Hole hole;
    for (std::size_t i = 0; i < loop.corners.size(); ++i) {
      hole.corners.push_back(mesh_.positions[loop.corners[i]]);
      hole.normals.push_back(normals_.at(loop.corners[i].value));
      hole.beyond.push_back(mesh_.positions[loop.beyond[i]]);
    }
    hole.joined = [this, &loop](std::uint32_t i, std::uint32_t j) {
      return edges_.contains(key_of(loop.corners[i], loop.corners[j]));
    };
    return hole;
  }

  /// The area of the cone over the loop stands for the hole's.
  std::string too_large(const BoundaryLoop& loop, const Hole& hole) const {
    const auto n = hole.corners.size();
    Point3 centre{};
    for (const Point3& p : hole.corners) centre += (1 / static_cast<double>(n)) * p;
    double area = 0;
    for (std::size_t i = 0; i < n; ++i) {
      area += norm(cross(hole.corners[i] - centre, hole.corners[(i + 1) % n] - centre)) / 2;
    }
    const double whole = areas_[component_of_.at(loop.corners.front().value)];
    if (area <= kLargestShare * whole) return {};
    return "its area of about " + std::to_string(area) + " is more than half of its component's, " +
           std::to_string(whole);
  }

  std::string fill_small(const BoundaryLoop& loop, const Hole& hole) {
    if (loop.corners.size() > kSmall) {
      return "it is longer than the " + std::to_string(kSmall) + " edges of a small hole";
    }
    LoopLimits limits;
    limits.may_join = [&](std::size_t i, std::size_t j) {
      return !hole.joined(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    };
    auto triangles = triangulate_loop({hole.corners, hole.beyond}, limits);
    if (!triangles) return "no triangles between its corners close it without folds or edges of three triangles";
    append(loop, {hole.corners, std::move(*triangles)});
    return {};
  }

  void append(const BoundaryLoop& loop, const Patch& patch) {
    const std::size_t corners = loop.corners.size();
    const std::size_t first = mesh_.positions.size();
    const auto vertex = [&](std::uint32_t i) {
      return i < corners ? loop.corners[i] : VertexIndex(first + i - corners);
    };
    append_attributes(loop, patch);
    mesh_.positions.insert(mesh_.positions.end(), patch.points.begin() + static_cast<std::ptrdiff_t>(corners),
                           patch.points.end());
    for (const Corners& t : patch.triangles) {
      mesh_.triangles.push_back({vertex(t[0]), vertex(t[1]), vertex(t[2])});
      for (std::size_t i = 0; i < 3; ++i) {
        if (t[i] < corners && t[(i + 1) % 3] < corners) edges_.insert(key_of(vertex(t[i]), vertex(t[(i + 1) % 3])));
      }
    }
    report_.vertices_added += patch.points.size() - corners;
    report_.triangles_added += patch.triangles.size();
  }

  /// Normals and colours of the new vertices.
  void append_attributes(const BoundaryLoop& loop, const Patch& patch) {
    const std::size_t corners = loop.corners.size();
    if (patch.points.size() == corners) return;
    const auto spread = [&](const auto& value) {
      std::vector<Point3> known;
      for (const VertexIndex v : loop.corners) known.push_back(value(v));
      return spread_harmonically(patch, known);
    };
    if (!mesh_.normals.empty()) {
      const auto normals = spread([&](VertexIndex v) -> Point3 {
        const Normal3& n = mesh_.normals[v];
        return {n[0], n[1], n[2]};
      });
      for (std::size_t i = corners; i < normals.size(); ++i) {
        const Point3 n = direction_of(normals[i]).value_or(Point3{0, 0, 1});
        mesh_.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
      }
    }
    if (mesh_.colors.empty()) return;
    const auto colours = spread([&](VertexIndex v) -> Point3 {
      const Color4& c = mesh_.colors[v];
      return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
    });
    const auto opacities = spread([&](VertexIndex v) -> Point3 { return {double(mesh_.colors[v][3]), 0, 0}; });
    const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0))); };
    for (std::size_t i = corners; i < colours.size(); ++i) {
      mesh_.colors.push_back({byte(colours[i][0]), byte(colours[i][1]), byte(colours[i][2]), byte(opacities[i][0])});
    }
  }

  TriangleMesh& mesh_;
  const FillParameters& parameters_;
  Context& context_;
  FillReport report_;
  /// Of boundary vertices: normals weighted by angles, and components.
  std::unordered_map<std::uint32_t, Point3> normals_;
  std::unordered_map<std::uint32_t, std::uint32_t> component_of_;
  std::vector<double> areas_;
  /// Edges between boundary vertices.
  std::unordered_set<std::uint64_t> edges_;
};

}  // namespace
}  // namespace filling

Result<FillReport> fill_holes(TriangleMesh& mesh, const FillParameters& parameters, Context& context) {
  try {
    return filling::Filling(mesh, parameters, context)();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left to fill the holes of a mesh of " +
                                               std::to_string(mesh.triangles.size()) + " triangles"};
  }
}

}  // namespace surfaced
