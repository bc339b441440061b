// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "base/vectors.hpp"
#include "hole_filling/angle_front.hpp"
#include "hole_filling/attributes.hpp"
#include "hole_filling/boundary_loops.hpp"
#include "hole_filling/cutting_back.hpp"
#include "hole_filling/hole_filling.hpp"
#include "hole_filling/ways.hpp"
#include "mesh/area_normal.hpp"
#include "quality/quality.hpp"

namespace surfaced {
namespace filling {
namespace {

/// A front's edges are as long as it is told or shorter, where points merge or meet: with this factor its points are as
/// dense as the vertices around (measured from points, `holes_from_points.py`).
constexpr double kFrontEdge = 1.1;
/// Share of its component's area above which a hole is no hole but the component's outside.
constexpr double kLargestShare = 0.5;

std::uint64_t key_of(VertexIndex a, VertexIndex b) {
  return (std::uint64_t{std::min(a, b).value} << 32U) | std::max(a, b).value;
}

/// One hole on its way.
struct Attempt {
  const BoundaryLoop* loop = nullptr;
  Hole hole{};
  /// Of kWays.
  std::size_t way = 0;
  std::optional<Patch> patch{};
  /// Edges between corners that the patch has put into `edges_`.
  std::vector<std::uint64_t> edges{};
  /// The patch crosses nothing.
  bool settled = false;
  /// Why the hole stays; empty as long as it does not.
  std::string reason{};
};

class Filling {
 public:
  Filling(TriangleMesh& mesh, Spacings* spacings, const FillParameters& parameters, Context& context)
      : mesh_(mesh), spacings_(spacings), parameters_(parameters), context_(context), loops_(boundary_loops(mesh)) {
    report_.loops = loops_.size();
    if (loops_.empty()) return;
    survey();
    for (const BoundaryLoop& loop : loops_) attempts_.push_back(attempt_at(loop));
  }

  const std::vector<BoundaryLoop>& loops() const { return loops_; }

  /// Which of the loops are holes to be filled.
  std::vector<bool> holes() const {
    std::vector<bool> holes;
    for (const Attempt& attempt : attempts_) holes.push_back(attempt.reason.empty());
    return holes;
  }

  /// Those of the loops that stay, once it has run.
  std::unordered_set<std::uint32_t> vertices_left_open() const {
    std::unordered_set<std::uint32_t> vertices;
    for (const Attempt& attempt : attempts_) {
      if (attempt.settled) continue;
      for (const VertexIndex v : attempt.loop->corners) vertices.insert(v.value);
    }
    return vertices;
  }

  Result<FillReport> operator()() {
    while (std::ranges::any_of(attempts_, [](const Attempt& a) { return a.reason.empty() && !a.settled; })) {
      if (Status tried = try_next_ways(); !tried) return std::move(tried).error();
      take_back_what_crosses();
    }
    for (Attempt& attempt : attempts_) conclude(attempt);
    return std::move(report_);
  }

 private:
  /// What is needed of the mesh around the loops: normals, edges between boundary vertices, areas of components.
  void survey() {
    for (const BoundaryLoop& loop : loops_) {
      for (const VertexIndex v : loop.corners) normals_.emplace(v.value, Point3{});
    }
    const Components components = components_of(mesh_);
    areas_.resize(components.count, 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Triangle& triangle = mesh_.triangles[t];
      const Point3 normal = area_normal(mesh_, triangle);
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

  Attempt attempt_at(const BoundaryLoop& loop) const {
    Attempt attempt{.loop = &loop};
    const bool small = parameters_.holes == FillParameters::Holes::small;
    attempt.reason = loop.obstacle;
    if (attempt.reason.empty() && small && loop.corners.size() > kSmall) {
      attempt.reason = "it is longer than the " + std::to_string(kSmall) + " edges of a small hole";
    }
    if (!attempt.reason.empty()) return attempt;
    attempt.hole = hole_of(loop);
    if (small) {
      attempt.way = kWays.size() - 1;
    } else {
      attempt.reason = too_large(loop, attempt.hole);
    }
    return attempt;
  }

  /// A patch for every hole that has none: the first of the ways left that makes one.
  Status try_next_ways() {
    for (std::size_t i = 0; i < attempts_.size(); ++i) {
      Attempt& attempt = attempts_[i];
      if (context_.cancelled()) return Error{ErrorCode::cancelled, "cancelled while filling holes"};
      context_.report(static_cast<double>(i + 1) / static_cast<double>(attempts_.size()));
      if (!attempt.reason.empty() || attempt.settled) continue;
      while (!attempt.patch && attempt.way < kWays.size()) {
        attempt.patch = cover(attempt.hole, kWays.at(attempt.way), parameters_.rotation);
        if (!attempt.patch) ++attempt.way;
      }
      if (attempt.patch) {
        note_edges(attempt);
      } else {
        attempt.reason = why_not(attempt.hole.corners.size());
      }
    }
    return Done{};
  }

  std::string why_not(std::size_t corners) const {
    if (parameters_.holes == FillParameters::Holes::small) {
      return "no triangles between its corners close it without folds, crossings or edges of three triangles";
    }
    return "no surface covers it without crossing another: not that of the advancing front (up to " +
           std::to_string(kLongestForAngles) + " edges), of the library (up to " + std::to_string(kLongestForLibrary) +
           ") or between its corners (up to " + std::to_string(kSmall) + "); it has " + std::to_string(corners);
  }

  /// Other holes must not join the same corners.
  void note_edges(Attempt& attempt) {
    const std::size_t corners = attempt.hole.corners.size();
    for (const Corners& t : attempt.patch->triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (t[i] >= corners || t[(i + 1) % 3] >= corners) continue;
        const std::uint64_t key = key_of(attempt.loop->corners[t[i]], attempt.loop->corners[t[(i + 1) % 3]]);
        if (edges_.insert(key).second) attempt.edges.push_back(key);
      }
    }
  }

  /// Puts all patches into a copy of the mesh's triangles and takes those back that cross it, themselves, or one that
  /// was there before.
  void take_back_what_crosses() {
    TriangleMesh filled{.positions = mesh_.positions, .triangles = mesh_.triangles, .normals = {}, .colors = {}};
    std::vector<Attempt*> owners;
    for (Attempt& attempt : attempts_) {
      if (!attempt.patch) continue;
      append_surface(filled, attempt);
      owners.resize(filled.triangles.size() - mesh_.triangles.size(), &attempt);
    }
    const std::size_t first = mesh_.triangles.size();
    std::unordered_set<const Attempt*> crossing;
    for (const auto& [a, b] : intersections_from(filled, first)) {
      Attempt* const at_a = a < first ? nullptr : owners[a - first];
      Attempt* const at_b = b < first ? nullptr : owners[b - first];
      Attempt* later = std::max(at_a, at_b);
      if (later->settled) later = std::min(at_a, at_b);
      if (later != nullptr && !later->settled) crossing.insert(later);
    }
    for (Attempt& attempt : attempts_) {
      if (!attempt.patch || attempt.settled) continue;
      attempt.settled = !crossing.contains(&attempt);
      if (!attempt.settled) take_back(attempt);
    }
  }

  void take_back(Attempt& attempt) {
    for (const std::uint64_t key : attempt.edges) edges_.erase(key);
    attempt.edges.clear();
    attempt.patch.reset();
    ++attempt.way;
  }

  void conclude(Attempt& attempt) {
    const BoundaryLoop& loop = *attempt.loop;
    if (!attempt.reason.empty()) {
      report_.left.push_back({loop.corners.front(), loop.corners.size(), std::move(attempt.reason)});
      return;
    }
    ++report_.filled;
    if (kWays.at(attempt.way).cover == Cover::library) ++report_.filled_by_library;
    append_attributes(mesh_, loop, *attempt.patch);
    append_surface(mesh_, attempt);
    report_.vertices_added += attempt.patch->points.size() - loop.corners.size();
    report_.triangles_added += attempt.patch->triangles.size();
  }

  static void append_surface(TriangleMesh& mesh, const Attempt& attempt) {
    const std::vector<VertexIndex>& corners = attempt.loop->corners;
    const Patch& patch = *attempt.patch;
    const std::size_t first = mesh.positions.size();
    const auto vertex = [&](std::uint32_t i) {
      return i < corners.size() ? corners[i] : VertexIndex(first + i - corners.size());
    };
    mesh.positions.insert(mesh.positions.end(), patch.points.begin() + static_cast<std::ptrdiff_t>(corners.size()),
                          patch.points.end());
    for (const Corners& t : patch.triangles) mesh.triangles.push_back({vertex(t[0]), vertex(t[1]), vertex(t[2])});
  }

  Hole hole_of(const BoundaryLoop& loop) const {
    Hole hole;
    for (std::size_t i = 0; i < loop.corners.size(); ++i) {
      hole.corners.push_back(mesh_.positions[loop.corners[i]]);
      hole.normals.push_back(normals_.at(loop.corners[i].value));
      hole.beyond.push_back(mesh_.positions[loop.beyond[i]]);
    }
    set_spacings(hole, loop);
    hole.joined = [this, &loop](std::uint32_t i, std::uint32_t j) {
      return edges_.contains(key_of(loop.corners[i], loop.corners[j]));
    };
    return hole;
  }

  /// Where nothing is known around a corner, the mean edge of the rim.
  void set_spacings(Hole& hole, const BoundaryLoop& loop) const {
    const std::size_t n = loop.corners.size();
    double mean = 0;
    for (std::size_t i = 0; i < n; ++i) {
      mean += norm(hole.corners[(i + 1) % n] - hole.corners[i]) / static_cast<double>(n);
    }
    for (const VertexIndex v : loop.corners) {
      const double spacing = spacings_ == nullptr ? 0 : spacings_->at(v);
      hole.spacings.push_back(kFrontEdge * (spacing > 0 ? spacing : mean));
    }
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

  TriangleMesh& mesh_;
  /// None where holes are small.
  Spacings* spacings_;
  const FillParameters& parameters_;
  Context& context_;
  std::vector<BoundaryLoop> loops_;
  FillReport report_;
  std::vector<Attempt> attempts_;
  /// Of boundary vertices: normals weighted by angles, and components.
  std::unordered_map<std::uint32_t, Point3> normals_;
  std::unordered_map<std::uint32_t, std::uint32_t> component_of_;
  std::vector<double> areas_;
  /// Edges between boundary vertices.
  std::unordered_set<std::uint64_t> edges_;
};

/// Cuts that no patch has taken the place of, because their hole stays.
bool in_vain(const TriangleMesh& mesh, const Cut& cut, const std::unordered_set<std::uint32_t>& left) {
  return std::ranges::any_of(cut.triangles, [&](std::uint32_t t) {
    return std::ranges::any_of(mesh.triangles[t], [&](VertexIndex v) { return left.contains(v.value); });
  });
}

/// Cuts back what is stretched around the holes, and fills them; where a hole cannot be filled then, what was cut there
/// comes back, and all holes are filled anew.
Result<FillReport> cut_and_fill(TriangleMesh& mesh, const FillParameters& parameters, Context& context) {
  if (parameters.holes == FillParameters::Holes::small) return Filling(mesh, nullptr, parameters, context)();
  Spacings spacings(mesh);
  std::vector<Cut> cuts;
  {
    const Filling survey(mesh, &spacings, parameters, context);
    cuts = cut_back(mesh, survey.loops(), survey.holes(), spacings);
    if (survey.loops().empty() && cuts.empty()) return FillReport{};
  }
  constexpr int kMostRounds = 3;
  for (int round = 1;; ++round) {
    if (round == kMostRounds) cuts.clear();
    TriangleMesh open = without(mesh, cuts);
    Filling filling(open, &spacings, parameters, context);
    Result<FillReport> report = filling();
    if (!report) return report;
    const std::unordered_set<std::uint32_t> left = filling.vertices_left_open();
    if (std::erase_if(cuts, [&](const Cut& cut) { return in_vain(mesh, cut, left); }) > 0) continue;
    for (const Cut& cut : cuts) {
      report->triangles_cut += cut.triangles.size();
      report->spans_opened += cut.spanned ? 1U : 0U;
    }
    mesh = std::move(open);
    return report;
  }
}

}  // namespace
}  // namespace filling

Result<FillReport> fill_holes(TriangleMesh& mesh, const FillParameters& parameters, Context& context) {
  try {
    return filling::cut_and_fill(mesh, parameters, context);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left to fill the holes of a mesh of " +
                                               std::to_string(mesh.triangles.size()) + " triangles"};
  }
}

}  // namespace surfaced
