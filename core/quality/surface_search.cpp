// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <queue>

#include "base/parallel.hpp"
#include "quality/quality.hpp"

namespace surfaced {
namespace {

// Distances are measured, nothing is decided by them: doubles do.
using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 point(const Point3& p) { return {p[0], p[1], p[2]}; }
Point3 point(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

/// The triangles that have an area, and which they are in the mesh.
struct SurfaceSearch::Impl {
  explicit Impl(const TriangleMesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& corners = mesh.triangles[t];
      const Point3& a = mesh.positions[corners[0]];
      const Point3& b = mesh.positions[corners[1]];
      const Point3& c = mesh.positions[corners[2]];
      if (!(shape_of(a, b, c).area > 0)) continue;
      triangles.emplace_back(point(a), point(b), point(c));
      number.emplace_back(t);
    }
    tree.insert(triangles.cbegin(), triangles.cend());
    tree.do_not_accelerate_distance_queries();
    tree.build();
  }

  Triangles triangles;
  std::vector<TriangleIndex> number;
  Tree tree;
};

SurfaceSearch::SurfaceSearch(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
SurfaceSearch::~SurfaceSearch() = default;

bool SurfaceSearch::empty() const { return impl_->triangles.empty(); }

SurfaceSearch::Closest SurfaceSearch::closest(const Point3& query, std::size_t hint) const {
  const auto near = impl_->triangles.cbegin() + static_cast<std::ptrdiff_t>(hint);
  const Kernel::Point_3 from = point(query);
  const Kernel::Point_3 first = Kernel().construct_projected_point_3_object()(*near, from);
  const auto found = impl_->tree.closest_point_and_primitive(from, {first, near});
  const Point3 at = point(found.first);
  const auto place = static_cast<std::size_t>(found.second - impl_->triangles.cbegin());
  return {.point = at, .triangle = impl_->number[place], .place = place, .distance = norm(at - query)};
}

double SurfaceSearch::distance_to(std::size_t place, const Point3& query) const {
  return std::sqrt(CGAL::squared_distance(point(query), impl_->triangles[place]));
}

std::optional<std::array<Point3, 2>> SurfaceSearch::shared_edge(std::size_t place, std::size_t other) const {
  std::array<Point3, 2> ends;
  std::size_t found = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      if (impl_->triangles[place].vertex(i) != impl_->triangles[other].vertex(k)) continue;
      if (found < 2) ends.at(found) = point(impl_->triangles[place].vertex(i));
      ++found;
    }
  }
  return found == 2 ? std::optional(ends) : std::nullopt;
}

namespace {

/// A piece of a triangle, and a bound on how far its points are from the surface.
struct Piece {
  std::array<Point3, 3> corners;
  std::array<SurfaceSearch::Closest, 3> closest;
  double upper = 0;

  bool operator<(const Piece& other) const { return upper < other.upper; }
};

Point3 middle(const Point3& a, const Point3& b) {
  return {a[0] + (b[0] - a[0]) / 2, a[1] + (b[1] - a[1]) / 2, a[2] + (b[2] - a[2]) / 2};
}

/// How far the corners of a piece are from one triangle; distances to a convex set are convex, so no point of the piece
/// is farther.
double farthest_corner(const SurfaceSearch& search, const Piece& piece, std::size_t place) {
  double farthest = 0;
  for (const Point3& corner : piece.corners) farthest = std::max(farthest, search.distance_to(place, corner));
  return farthest;
}

double between(const Point3& a, const Point3& b, const std::array<Point3, 2>& edge) {
  return std::sqrt(
      CGAL::squared_distance(Kernel::Segment_3(point(a), point(b)), Kernel::Segment_3(point(edge[0]), point(edge[1]))));
}

/// For a piece that lies over two triangles A and B with a common edge, corner k over A, the others over B: cut where
/// the two sides from k come closest to the edge, its parts map linearly into A and into B, and no point moves farther
/// than the corners and the cuts do. Infinite for other pieces.
double over_an_edge(const SurfaceSearch& search, const Piece& piece, double greatest) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const std::size_t last = (k + 2) % 3;
    if (piece.closest[next].place != piece.closest[last].place || piece.closest[k].place == piece.closest[next].place) {
      continue;
    }
    const auto edge = search.shared_edge(piece.closest[k].place, piece.closest[next].place);
    if (!edge) return kNone;
    return std::max({greatest, between(piece.corners[k], piece.corners[next], *edge),
                     between(piece.corners[k], piece.corners[last], *edge)});
  }
  return kNone;
}

/// Bounds the piece, not more tightly than to `enough`. No point of it is farther from all corners than its longest
/// edge over √3.
void bound(const SurfaceSearch& search, Piece& piece, double enough) {
  const auto& [a, b, c] = piece.corners;
  double greatest = 0;
  for (const SurfaceSearch::Closest& each : piece.closest) greatest = std::max(greatest, each.distance);
  piece.upper = greatest + std::max({norm(b - a), norm(c - b), norm(a - c)}) / std::sqrt(3.0);
  for (const SurfaceSearch::Closest& each : piece.closest) {
    if (piece.upper <= enough) return;
    piece.upper = std::min(piece.upper, farthest_corner(search, piece, each.place));
  }
  piece.upper = std::min(piece.upper, over_an_edge(search, piece, greatest));
  if (piece.upper <= enough) return;
  const std::size_t central = search.closest(middle(middle(a, b), c), piece.closest[0].place).place;
  piece.upper = std::min(piece.upper, farthest_corner(search, piece, central));
}

/// Cuts a piece at the middles of its edges.
std::array<Piece, 4> quarters(const SurfaceSearch& search, const Piece& piece, double& lower) {
  std::array<Point3, 3> middles;
  std::array<SurfaceSearch::Closest, 3> closest;
  for (std::size_t k = 0; k < 3; ++k) {
    middles[k] = middle(piece.corners[k], piece.corners[(k + 1) % 3]);
    closest[k] = search.closest(middles[k], piece.closest[k].place);
    lower = std::max(lower, closest[k].distance);
  }
  std::array<Piece, 4> parts;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t before = (k + 2) % 3;
    parts[k] = {{piece.corners[k], middles[k], middles[before]}, {piece.closest[k], closest[k], closest[before]}};
  }
  parts[3] = {middles, closest};
  return parts;
}

/// Thrown out of the loops, also out of tasks.
struct ShallStop {};

/// Asks now and then whether to go on. One for each thread's piece of work.
class Asking {
 public:
  Asking(const GoOn& go_on, const std::atomic<double>& done) : go_on_(go_on), done_(done) {}

  void tick() {
    constexpr std::size_t kTicksBetweenQuestions = 256;
    if (go_on_ && ticks_++ % kTicksBetweenQuestions == 0 && !go_on_(done_.load(std::memory_order_relaxed))) {
      throw ShallStop{};
    }
  }

 private:
  const GoOn& go_on_;
  const std::atomic<double>& done_;
  std::size_t ticks_ = 0;
};

/// Distances of the vertices that triangles use, each search beginning where the last one ended.
std::vector<SurfaceSearch::Closest> closest_of_vertices(const TriangleMesh& from, const SurfaceSearch& to,
                                                        double& lower, Asking asking) {
  std::vector<SurfaceSearch::Closest> closest(from.positions.size());
  std::vector<bool> known(from.positions.size(), false);
  std::size_t hint = 0;
  for (const Triangle& t : from.triangles) {
    for (const VertexIndex v : t) {
      if (known[v]) continue;
      known[v] = true;
      asking.tick();
      closest[v] = to.closest(from.positions[v], hint);
      hint = closest[v].place;
      lower = std::max(lower, closest[v].distance);
    }
  }
  return closest;
}

/// Branch and bound over some of the triangles, beginning with what is known of all.
class Bounding {
 public:
  Bounding(const TriangleMesh& from, const SurfaceSearch& to, const std::vector<SurfaceSearch::Closest>& closest,
           SurfaceDistance known, double least, Asking asking)
      : from_(from), to_(to), closest_(closest), distance_(known), least_(least), asking_(asking) {}

  SurfaceDistance run(std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      asking_.tick();
      const auto& [a, b, c] = from_.triangles[t];
      keep({{from_.positions[a], from_.positions[b], from_.positions[c]}, {closest_[a], closest_[b], closest_[c]}});
    }
    const std::size_t most_cuts = kMostCutsPerTriangle * (last - first);
    for (std::size_t cuts = 0; !pieces_.empty() && cuts < most_cuts; ++cuts) {
      const Piece worst = pieces_.top();
      if (worst.upper <= enough()) break;
      pieces_.pop();
      asking_.tick();
      for (const Piece& part : quarters(to_, worst, distance_.lower)) keep(part);
    }
    if (!pieces_.empty()) distance_.upper = std::max(distance_.upper, pieces_.top().upper);
    return distance_;
  }

 private:
  static constexpr double kTolerance = 0.1;
  static constexpr std::size_t kMostCutsPerTriangle = 60;

  double enough() const { return std::max((1 + kTolerance) * distance_.lower, least_); }

  void keep(Piece piece) {
    bound(to_, piece, enough());
    if (piece.upper <= enough()) {
      distance_.upper = std::max(distance_.upper, piece.upper);
    } else {
      pieces_.push(piece);
    }
  }

  const TriangleMesh& from_;
  const SurfaceSearch& to_;
  const std::vector<SurfaceSearch::Closest>& closest_;
  SurfaceDistance distance_;
  /// What rounding leaves of distances that are 0.
  double least_;
  Asking asking_;
  std::priority_queue<Piece> pieces_;
};

SurfaceDistance bounded(const TriangleMesh& from, const SurfaceSearch& to, unsigned threads, const GoOn& go_on) {
  // Blocks do not learn from each other, so the result does not depend on the number of threads.
  constexpr std::size_t kBlock = 2048;
  SurfaceDistance distance;
  std::atomic<double> done = 0;
  const Asking asking(go_on, done);
  const std::vector<SurfaceSearch::Closest> closest = closest_of_vertices(from, to, distance.lower, asking);
  double size = 0;
  for (const Point3& p : from.positions) size = std::max({size, std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
  const SurfaceDistance known{distance.lower, distance.lower};
  std::vector<SurfaceDistance> of_block((from.triangles.size() + kBlock - 1) / kBlock);
  parallel_tasks(threads, of_block.size(), [&](std::size_t block) {
    const std::size_t last = std::min((block + 1) * kBlock, from.triangles.size());
    of_block[block] = Bounding(from, to, closest, known, 1e-12 * size, asking).run(block * kBlock, last);
    done.fetch_add(1 / static_cast<double>(of_block.size()), std::memory_order_relaxed);
  });
  for (const SurfaceDistance& each : of_block) {
    distance.lower = std::max(distance.lower, each.lower);
    distance.upper = std::max(distance.upper, each.upper);
  }
  return distance;
}

}  // namespace

SurfaceDistance surface_distance(const TriangleMesh& from, const SurfaceSearch& to, unsigned threads) {
  return *surface_distance(from, to, threads, {});
}

std::optional<SurfaceDistance> surface_distance(const TriangleMesh& from, const SurfaceSearch& to, unsigned threads,
                                                const GoOn& go_on) {
  if (from.triangles.empty() || to.empty()) return SurfaceDistance{};
  try {
    return bounded(from, to, threads, go_on);
  } catch (const ShallStop&) {
    return std::nullopt;
  }
}

}  // namespace surfaced
