// SPDX-License-Identifier: GPL-3.0-or-later
// Source: W. Gong, Y.-J. Liu, K. Tang, T. Wu, "Approximate Delaunay mesh reconstruction and quality estimation from
// point samples", J. Comput. Appl. Math. 274 (2015), §3.3; the rules are those of C. S. Chong, NUS 2008.
#include "hole_filling/angle_front.hpp"

#include <algorithm>
#include <numbers>
#include <set>
#include <unordered_set>

#include "base/vectors.hpp"

namespace surfaced::filling {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// The limits of the three rules.
constexpr double kNarrow = 75 * kDegree;
constexpr double kWide = 135 * kDegree;
constexpr double kEquilateral = 60 * kDegree;
/// A new point merges with the front within this share of the spacing.
constexpr double kMerging = 0.5;
/// How far around a new point the front is looked at, in spacings.
constexpr double kSight = 1.5;
/// A triangle that joins parts of the front faces its side within this cosine.
constexpr double kLeastCosine = 0.2;

std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
  return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
}

/// One place on a front. A vertex may have a place on several fronts, one on each.
struct Node {
  std::uint32_t vertex = 0;
  std::uint32_t previous = 0;
  std::uint32_t next = 0;
  std::uint32_t front = 0;
  double angle = 0;
  bool alive = true;
  /// Nothing could be done here since its neighbours changed last.
  bool blocked = false;
};

class AngleFront {
 public:
  AngleFront(const Hole& hole, std::size_t most_points)
      : hole_(hole), corners_(hole.corners.size()), most_points_(corners_ + most_points) {
    patch_.points = hole.corners;
    normals_ = hole.normals;
    spacings_ = hole.spacings;
  }

  std::optional<Patch> operator()() {
    begin();
    const std::size_t most_steps = std::max(corners_ * corners_, most_points_);
    for (std::size_t step = 0; !queue_.empty(); ++step) {
      const std::uint32_t at = std::get<2>(*queue_.begin());
      if (step == most_steps || patch_.points.size() > most_points_) return std::nullopt;
      if (nodes_[at].blocked) return std::nullopt;  // blocked ones come last: nothing can be done anywhere
      advance(at);
    }
    return std::move(patch_);
  }

 private:
  // The queue: what can be done first, then the smallest angle, then the oldest vertex.
  std::tuple<double, std::uint32_t, std::uint32_t> entry(std::uint32_t i) const {
    const Node& node = nodes_[i];
    return {node.blocked ? 4 * std::numbers::pi : node.angle, node.vertex, i};
  }

  void begin() {
    const auto n = static_cast<std::uint32_t>(corners_);
    for (std::uint32_t i = 0; i < n; ++i) nodes_.push_back({i, (i + n - 1) % n, (i + 1) % n, 0, 0, true, false});
    face_fronts(0);
  }

  /// Gives the front through a node a number, its facing, and its nodes their angles.
  void face_fronts(std::uint32_t start) {
    const auto front = static_cast<std::uint32_t>(facings_.size());
    Point3 area{};
    const Point3 origin = point(start);
    std::uint32_t i = start;
    do {
      area += cross(point(i) - origin, point(nodes_[i].next) - origin);
      i = nodes_[i].next;
    } while (i != start);
    facings_.push_back(direction_of(area).value_or(Point3{}));
    do {
      if (front > 0) queue_.erase(entry(i));
      nodes_[i].front = front;
      measure(i);
      i = nodes_[i].next;
    } while (i != start);
  }

  const Point3& point(std::uint32_t node) const { return patch_.points[nodes_[node].vertex]; }

  /// The direction the surface faces at a node: between that of the triangles there and that of the front as a whole,
  /// which makes the front close where tangent planes would lead it away (a tube's end).
  Point3 facing(std::uint32_t i) const {
    const Point3 own = direction_of(normals_[nodes_[i].vertex]).value_or(Point3{});
    const Point3& whole = facings_[nodes_[i].front];
    constexpr double kOpposed = 0.5;
    const Point3 sum = own + whole;
    if (norm(sum) > kOpposed) return *direction_of(sum);
    return direction_of(whole).value_or(own);
  }

  /// The angle inside the hole from the next edge to the previous one, 0..2π, in the plane of `facing`.
  double angle_at(std::uint32_t i) const {
    const Point3 normal = facing(i);
    const Point3 a = flat(point(nodes_[i].next) - point(i), normal);
    const Point3 b = flat(point(nodes_[i].previous) - point(i), normal);
    const double angle = std::atan2(dot(normal, cross(a, b)), dot(a, b));
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  }

  static Point3 flat(const Point3& v, const Point3& normal) { return v - dot(v, normal) * normal; }

  /// Takes the angle of a node anew; it has no entry in the queue.
  void measure(std::uint32_t i) {
    nodes_[i].angle = angle_at(i);
    nodes_[i].blocked = false;
    queue_.insert(entry(i));
  }

  void measure_again(std::uint32_t i) {
    if (!nodes_[i].alive) return;
    queue_.erase(entry(i));
    measure(i);
  }

  void block(std::uint32_t i) {
    queue_.erase(entry(i));
    nodes_[i].blocked = true;
    queue_.insert(entry(i));
  }

  /// Paper 3, §3.3, step 3 at the front vertex v between p and n.
  void advance(std::uint32_t v) {
    const std::uint32_t p = nodes_[v].previous;
    const std::uint32_t n = nodes_[v].next;
    const double angle = nodes_[v].angle;
    bool done = false;
    if (angle <= kNarrow || nodes_[n].next == p) {
      done = join(v);
    } else if (angle <= kWide) {
      done = add_one(v);
    } else {
      done = add_two(v);
    }
    if (!done && nodes_[v].alive) block(v);
  }

  /// Rule (a): one triangle between the neighbours; v leaves the front, which the paper calls no update.
  bool join(std::uint32_t v) {
    const std::uint32_t p = nodes_[v].previous;
    if (!may_glue(p, nodes_[v].next)) return false;
    glue(p, nodes_[v].next);
    return true;
  }

  double spacing(std::uint32_t node) const { return spacings_[nodes_[node].vertex]; }

  /// A direction in the plane at v, turned from the next edge by `angle`.
  Point3 into_hole(std::uint32_t v, double angle) const {
    const Point3 normal = facing(v);
    const Point3 along = flat(point(nodes_[v].next) - point(v), normal);
    return turned(direction_of(along).value_or(along), normal, std::cos(angle), std::sin(angle));
  }

  /// Rule (b): a point on the bisector, two triangles. The paper's new edges have the mean length of the two at the
  /// front, which short edges make shorter and stretched ones longer; ours the spacing there.
  bool add_one(std::uint32_t v) {
    const Point3 q = point(v) + spacing(v) * into_hole(v, nodes_[v].angle / 2);
    const std::uint32_t p = nodes_[v].previous;
    const std::uint32_t apex = apex_near(p, q, spacing(v));
    if (apex == kNobody) return false;
    glue(p, apex);
    // Now v lies between the apex and n, unless the apex was n.
    if (nodes_[v].alive && nodes_[nodes_[v].previous].vertex == nodes_[apex].vertex) join(v);
    return true;
  }

  /// Rule (c): an equilateral triangle on both edges; a third one where the gap between them is narrow.
  bool add_two(std::uint32_t v) {
    const std::uint32_t p = nodes_[v].previous;
    const double whole = nodes_[v].angle;
    const double before = (spacing(p) + spacing(v)) / 2;
    const double after = (spacing(v) + spacing(nodes_[v].next)) / 2;
    const Point3 q2 = point(v) + after * into_hole(v, kEquilateral);
    const Point3 q1 = point(v) + before * into_hole(v, whole - kEquilateral);
    bool done = false;
    if (const std::uint32_t apex = apex_near(p, q1, before); apex != kNobody) {
      glue(p, apex);
      done = true;
    }
    if (!nodes_[v].alive) return done;
    if (done && norm(q2 - q1) < kMerging * after) return join(v) || done;  // the second point merges with the first
    if (const std::uint32_t apex = apex_near(v, q2, after); apex != kNobody) {
      glue(v, apex);
      done = true;
    }
    if (done && nodes_[v].alive && nodes_[v].angle <= kNarrow) join(v);
    return done;
  }

  static constexpr std::uint32_t kNobody = 0xFFFFFFFFU;

  /// Where a triangle over the edge at `a` that aims at q shall have its apex: a front vertex close to q, or one that q
  /// would pass, or a new node at q; nobody if none of them may be taken.
  std::uint32_t apex_near(std::uint32_t a, const Point3& q, double length) {
    std::vector<std::pair<double, std::uint32_t>> near;
    const bool passes = look_around(a, q, length, near);
    for (const auto& [distance, node] : near) {
      if (!passes && distance >= kMerging * length) break;
      if (may_glue(a, node) && faces_well(a, point(node)) && !crosses_front(a, point(node), near)) return node;
    }
    const bool crowded = passes || (!near.empty() && near.front().first < kMerging * length);
    if (crowded || !faces_well(a, q) || !is_finite(q)) return kNobody;
    return new_node(a, q);
  }

  /// The nodes of a's front around q, nearest first; whether the edges to q would cross the front.
  bool look_around(std::uint32_t a, const Point3& q, double length,
                   std::vector<std::pair<double, std::uint32_t>>& near) const {
    const std::uint32_t b = nodes_[a].next;
    for (std::uint32_t i = nodes_[b].next; i != a; i = nodes_[i].next) {
      const double distance = norm(point(i) - q);
      if (distance < kSight * length) near.emplace_back(distance, i);
    }
    std::ranges::sort(near);
    return crosses_front(a, q, near);
  }

  /// Whether the edges from a and its next to q cross an edge of the front near q, seen along the facing.
  bool crosses_front(std::uint32_t a, const Point3& q,
                     const std::vector<std::pair<double, std::uint32_t>>& near) const {
    const Point3 normal = facing(a);
    const std::uint32_t b = nodes_[a].next;
    const Point3& beyond_b = point(nodes_[b].next);
    if (beyond_b != q && crossing(point(a), q, point(b), beyond_b, normal)) return true;
    for (const auto& [distance, i] : near) {
      const std::uint32_t j = nodes_[i].next;
      if (point(i) == q || point(j) == q) continue;
      if (j != a && crossing(point(a), q, point(i), point(j), normal)) return true;
      if (crossing(point(b), q, point(i), point(j), normal)) return true;
    }
    return false;
  }

  static bool crossing(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Point3& normal) {
    const auto side = [&](const Point3& x, const Point3& y, const Point3& z) {
      return dot(normal, cross(y - x, z - x)) > 0;
    };
    return side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b);
  }

  bool faces_well(std::uint32_t a, const Point3& q) const {
    const auto normal = direction_of(cross(point(nodes_[a].next) - point(a), q - point(a)));
    return normal && dot(*normal, facing(a)) >= kLeastCosine;
  }

  std::uint32_t new_node(std::uint32_t a, const Point3& q) {
    const auto vertex = static_cast<std::uint32_t>(patch_.points.size());
    patch_.points.push_back(q);
    normals_.push_back({});
    spacings_.push_back((spacing(a) + spacing(nodes_[a].next)) / 2);
    nodes_.push_back({vertex, kNobody, kNobody, nodes_[a].front, 0, true, false});
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }

  bool joined(std::uint32_t u, std::uint32_t v) const {
    if (edges_.contains(key_of(u, v))) return true;
    return u < corners_ && v < corners_ && hole_.joined(u, v);
  }

  /// Whether the triangle over the edge at `a` with this apex of the same front makes no edge that exists already.
  bool may_glue(std::uint32_t a, std::uint32_t apex) const {
    const std::uint32_t b = nodes_[a].next;
    if (apex == a || apex == b) return false;
    const bool after = nodes_[b].next == apex;
    const bool before = nodes_[apex].next == a;
    return (before || !joined(nodes_[a].vertex, nodes_[apex].vertex)) &&
           (after || !joined(nodes_[b].vertex, nodes_[apex].vertex));
  }

  void leave(std::uint32_t i) {
    queue_.erase(entry(i));
    nodes_[i].alive = false;
  }

  void link(std::uint32_t i, std::uint32_t j) {
    nodes_[i].next = j;
    nodes_[j].previous = i;
  }

  /// Adds the triangle over the edge from `a` to its next with the apex: a new node, or one of the same front.
  void glue(std::uint32_t a, std::uint32_t apex) {
    const std::uint32_t b = nodes_[a].next;
    add_triangle(nodes_[a].vertex, nodes_[b].vertex, nodes_[apex].vertex);
    const bool after = nodes_[b].next == apex;
    const bool before = nodes_[apex].next == a;
    if (nodes_[apex].next == kNobody) {
      link(a, apex);
      link(apex, b);
      measure(apex);
    } else if (after && before) {
      for (const std::uint32_t i : {a, b, apex}) leave(i);
      return;
    } else if (after) {
      leave(b);
      link(a, apex);
    } else if (before) {
      leave(a);
      link(apex, b);
    } else {
      split(a, b, apex);
      return;
    }
    for (const std::uint32_t i : {a, b, apex}) measure_again(i);
  }

  /// The front meets itself: one part keeps the apex's node, the other takes a new one.
  void split(std::uint32_t a, std::uint32_t b, std::uint32_t apex) {
    const auto twin = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(nodes_[apex]);
    queue_.insert(entry(twin));
    link(nodes_[apex].previous, twin);
    link(twin, b);
    link(a, apex);
    face_fronts(apex);
    face_fronts(twin);
  }

  void add_triangle(std::uint32_t u, std::uint32_t v, std::uint32_t w) {
    patch_.triangles.push_back({u, v, w});
    for (const auto& [x, y] : {std::pair{u, v}, std::pair{v, w}, std::pair{w, u}}) edges_.insert(key_of(x, y));
    const auto& p = patch_.points;
    const Point3 normal = direction_of(cross(p[v] - p[u], p[w] - p[u])).value_or(Point3{});
    for (const std::uint32_t x : {u, v, w}) {
      if (x >= corners_) normals_[x] += normal;
    }
  }

  const Hole& hole_;
  std::size_t corners_;
  std::size_t most_points_;
  Patch patch_;
  /// At corners the mesh's normals, at new points the sum of their triangles'.
  std::vector<Point3> normals_;
  std::vector<double> spacings_;
  std::vector<Node> nodes_;
  std::vector<Point3> facings_;
  std::set<std::tuple<double, std::uint32_t, std::uint32_t>> queue_;
  std::unordered_set<std::uint64_t> edges_;
};

}  // namespace

std::optional<Patch> cover_by_angles(const Hole& hole, std::size_t most_points) {
  return AngleFront(hole, most_points)();
}

}  // namespace surfaced::filling
