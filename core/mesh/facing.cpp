// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/facing.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/area_normal.hpp"

namespace surfaced {
namespace {

/// So many normals must agree to be heeded; of normals with random signs half do.
constexpr double kTrusted = 0.8;
/// Parts with fewer normals than this say nothing of whether they are random.
constexpr std::size_t kFewNormals = 20;
/// So much of a part must be seen from its front to be oriented by a viewpoint. Of a closed body about half is.
constexpr double kSeen = 0.75;
/// Of a height field so much of the projected area has the same sign, and so much of the area is there when projected.
constexpr double kOneSided = 0.9;
constexpr double kLeastProjected = 0.3;
/// A normal farther from that of the faces than 60 degrees is none of them, and if most are, none is heeded.
constexpr double kLeastCosine = 0.5;

/// Evidence for and against the side that is the front now.
struct Votes {
  double front = 0;
  double back = 0;

  void add(double vote) { (vote > 0 ? front : back) += std::abs(vote); }
  double sum() const { return front + back; }
  double share() const { return sum() > 0 ? std::max(front, back) / sum() : 0; }
  bool say_back() const { return back > front; }
};

struct Part {
  std::size_t triangles = 0;
  double area = 0;
  /// Areas as seen along y and z.
  std::array<Votes, 2> along;
  Votes seen;
  Votes normals;
};

struct Decision {
  bool turn = false;
  FacingReason reason = FacingReason::outwards;
  double share = 0;
};

Point3 as_point(const Normal3& n) { return {n[0], n[1], n[2]}; }

double cosine(const Point3& a, const Point3& b) {
  const double lengths = norm(a) * norm(b);
  return lengths > 0 ? dot(a, b) / lengths : 0;
}

class FrontFinder {
 public:
  FrontFinder(TriangleMesh& mesh, const FacingOptions& options)
      : mesh_(mesh), options_(options), components_(components_of(mesh)), parts_(components_.count) {}

  Facing run() {
    if (!mesh_.normals.empty()) facing_ = area_normals_at_vertices(mesh_.positions, mesh_.triangles);
    weigh_triangles();
    if (!mesh_.normals.empty()) weigh_normals();
    turn(decisions());
    if (!mesh_.normals.empty()) mend_normals();
    return found_;
  }

 private:
  void weigh_triangles() {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Triangle& triangle = mesh_.triangles[t];
      Part& part = parts_[components_.of_triangle[t]];
      const Point3 f = area_normal(mesh_, triangle);
      ++part.triangles;
      part.area += norm(f);
      for (std::size_t axis = 0; axis < 2; ++axis) part.along.at(axis).add(f[axis + 1]);
      if (!options_.viewpoint) continue;
      const Point3 sight = *options_.viewpoint - mesh_.positions[triangle[0]];
      part.seen.add(cosine(sight, f) * norm(f));
    }
  }

  /// A vertex counts once, for the part of its last triangle.
  void weigh_normals() {
    std::vector<std::uint32_t> part_of(mesh_.positions.size(), VertexIndex::kNone);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const VertexIndex v : mesh_.triangles[t]) part_of[v] = components_.of_triangle[t];
    }
    NormalsUse use;
    std::size_t along = 0;
    for (std::size_t v = 0; v < part_of.size(); ++v) {
      if (part_of[v] == VertexIndex::kNone) continue;
      const double c = cosine(as_point(mesh_.normals[v]), facing_[v]);
      ++use.vertices;
      along += std::abs(c) >= kLeastCosine ? 1U : 0U;
      if (c != 0) parts_[part_of[v]].normals.add(c > 0 ? 1 : -1);
    }
    heed_axes_ = 2 * along >= use.vertices;
    judge_normals(use);
    found_.normals = use;
  }

  /// Small parts agree by chance: those are asked only if there is no other.
  void judge_normals(NormalsUse& use) const {
    Votes all;
    Votes large;
    for (const Part& part : parts_) {
      const double most = std::max(part.normals.front, part.normals.back);
      const double rest = part.normals.sum() - most;
      all.front += most;
      all.back += rest;
      if (part.normals.sum() < static_cast<double>(kFewNormals)) continue;
      large.front += most;
      large.back += rest;
    }
    use.agreeing = all.sum() > 0 ? all.front / all.sum() : 0;
    const Votes& asked = large.sum() > 0 ? large : all;
    use.trusted = heed_axes_ && asked.sum() > 0 && asked.front >= kTrusted * asked.sum();
  }

  std::vector<Decision> decisions() const {
    std::vector<Decision> made;
    made.reserve(parts_.size());
    for (const Part& part : parts_) made.push_back(decision_for(part));
    return made;
  }

  Decision decision_for(const Part& part) const {
    switch (options_.rule) {
      case FacingRule::up:
        return by(part.along.at(is_field(part, 0) && !is_field(part, 1) ? 0 : 1), FacingReason::up);
      case FacingRule::viewpoint:
        return by(part.seen, FacingReason::viewpoint);
      case FacingRule::outwards:
        return {};
      default:
        break;
    }
    Decision decision = automatic(part);
    if (options_.rule == FacingRule::flip) decision.turn = !decision.turn;
    return decision;
  }

  Decision automatic(const Part& part) const {
    if (found_.normals && found_.normals->trusted && part.normals.sum() > 0)
      return by(part.normals, FacingReason::normals);
    if (part.seen.share() >= kSeen) return by(part.seen, FacingReason::viewpoint);
    for (const std::size_t axis : {std::size_t{1}, std::size_t{0}}) {
      if (is_field(part, axis)) return by(part.along.at(axis), FacingReason::up);
    }
    return {};
  }

  static Decision by(const Votes& votes, FacingReason reason) { return {votes.say_back(), reason, votes.share()}; }

  /// Whether the part is a height field over the plane across the axis: 0 is y, 1 is z.
  static bool is_field(const Part& part, std::size_t axis) {
    const Votes& seen = part.along.at(axis);
    return seen.share() >= kOneSided && seen.sum() >= kLeastProjected * part.area;
  }

  void turn(const std::vector<Decision>& made) {
    double certain = 0;
    std::size_t told = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Decision& decision = made[components_.of_triangle[t]];
      ++found_.triangles.at(static_cast<std::size_t>(decision.reason));
      if (decision.reason != FacingReason::outwards) {
        certain += decision.share;
        ++told;
      }
      if (!decision.turn) continue;
      std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
      ++found_.turned;
    }
    if (told > 0) found_.certainty = certain / static_cast<double>(told);
    if (found_.turned > 0 && !mesh_.normals.empty())
      facing_ = area_normals_at_vertices(mesh_.positions, mesh_.triangles);
  }

  void mend_normals() {
    for (std::size_t v = 0; v < facing_.size(); ++v) {
      const double length = norm(facing_[v]);
      if (!(length > 0)) continue;
      Normal3& n = mesh_.normals[v];
      const double side = dot(as_point(n), facing_[v]);
      if (side > 0 && heed_axes_) continue;
      if (side < 0 && heed_axes_) {
        for (float& x : n) x = -x;
        ++found_.normals->turned;
        continue;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) n.at(axis) = static_cast<float>(facing_[v][axis] / length);
      ++found_.normals->computed;
    }
  }

  TriangleMesh& mesh_;
  const FacingOptions& options_;
  Components components_;
  std::vector<Part> parts_;
  std::vector<Point3> facing_;
  /// Whether most normals are near those of the faces, but for their sign.
  bool heed_axes_ = true;
  Facing found_;
};

}  // namespace

Facing face(TriangleMesh& mesh, const FacingOptions& options) {
  if (options.rule == FacingRule::outwards) orient_outwards(mesh);
  return FrontFinder(mesh, options).run();
}

}  // namespace surfaced
