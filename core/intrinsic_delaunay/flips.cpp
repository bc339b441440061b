// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/flips.hpp"

#include <algorithm>
#include <deque>
#include <iterator>
#include <limits>
#include <mutex>
#include <new>
#include <string>
#include <unordered_map>

#include "base/parallel.hpp"
#include "front/adoption.hpp"

namespace surfaced::idt {

using front::Edge;
using front::Face;
using front::Fans;
using front::kNoVertex;
using front::Places;
using front::Wedge;

namespace {

/// cos 60°: how far the normals of new faces may be from that of the mean plane, and of their neighbours.
constexpr double kLeastCosine = 0.5;
constexpr std::uint8_t kMostFlipsOfAnEdge = 10;

/// The angle at c of a triangle abc as the parts of its cotangent.
struct ApexAngle {
  ApexAngle(const Point3& a, const Point3& b, const Point3& c) {
    const Point3 ca = a - c;
    const Point3 cb = b - c;
    product = dot(ca, cb);
    area = norm(cross(ca, cb));
    lengths = norm(ca) * norm(cb);
  }
  double product;
  double area;
  double lengths;
};

/// Largest cotangent, hence that of the smallest angle, of the face; infinite without area.
double largest_cotangent(const Places& places, const Face& f) {
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const ApexAngle angle(places.position(f[(i + 1) % 3]), places.position(f[(i + 2) % 3]), places.position(f[i]));
    if (!(angle.area > 0)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, angle.product / angle.area);
  }
  return largest;
}

std::array<Face, 2> faces_before(const Diamond& d) { return {Face{d.a, d.b, d.left}, Face{d.b, d.a, d.right}}; }
std::array<Face, 2> faces_after(const Diamond& d) { return {Face{d.a, d.right, d.left}, Face{d.right, d.b, d.left}}; }

/// The same four points with the other diagonal: (right, left, a) and (left, right, b).
Diamond turned(const Diamond& d) { return {d.right, d.left, d.a, d.b}; }

/// Inradius over longest edge, the less of the two faces; zero without area.
double least_ratio(const Places& places, const Diamond& d) {
  double least = std::numeric_limits<double>::infinity();
  for (const Face& f : faces_before(d)) {
    std::array<double, 3> lengths;
    for (std::size_t i = 0; i < 3; ++i) lengths[i] = norm(places.position(f[(i + 1) % 3]) - places.position(f[i]));
    const double perimeter = lengths[0] + lengths[1] + lengths[2];
    least = std::min(least, norm(area_normal(places, f)) / (perimeter * std::ranges::max(lengths)));
  }
  return least;
}

/// Whether the other diagonal is as Delaunay as this one, which four points that are not in a plane allow, and shapes
/// its faces better.
bool is_better_turned(const Places& places, const Diamond& d) {
  /// Gains as small as this are rounding: grids have diagonals that are equally good.
  constexpr double kRoundingOfRatio = 1e-9;
  return !angles_exceed_pi(places, turned(d)) &&
         least_ratio(places, turned(d)) > least_ratio(places, d) * (1 + kRoundingOfRatio);
}

bool minimum_angle_rises(const Places& places, const Diamond& d) {
  const auto worst = [&](const std::array<Face, 2>& faces) {
    return std::max(largest_cotangent(places, faces[0]), largest_cotangent(places, faces[1]));
  };
  return worst(faces_after(d)) < worst(faces_before(d));
}

/// Both pairs of faces have the same vector area, the mean plane's normal: the new ones near it means convex.
bool convex_in_the_mean_plane(const Places& places, const Diamond& d) {
  const auto after = faces_after(d);
  const Point3 first = area_normal(places, after[0]);
  const Point3 second = area_normal(places, after[1]);
  const Point3 mean{first[0] + second[0], first[1] + second[1], first[2] + second[2]};
  return front::cosine(first, mean) >= kLeastCosine && front::cosine(second, mean) >= kLeastCosine;
}

class Flipping {
 public:
  Flipping(Fans& fans, Places& places, Context& context) : fans_(fans), places_(places), context_(context) {}

  Result<FlipCounts> operator()() {
    const auto [failing, improvable] = survey();
    if (Status done = towards_delaunay(failing); !done) return done.error();
    if (Status done = towards_better_shapes(improvable); !done) return done.error();
    counts_.not_flippable = still_failing();
    return counts_;
  }

 private:
  struct Survey {
    /// Edges with α1 + α2 > π.
    std::vector<Edge> failing;
    /// Of the others, those whose flip gives better faces without such an edge.
    std::vector<Edge> improvable;
  };

  Status towards_delaunay(const std::vector<Edge>& failing) {
    std::deque<Edge> waiting(failing.begin(), failing.end());
    for (std::size_t step = 1; !waiting.empty(); ++step) {
      if (stop_at(step)) return cancelled();
      const Edge e = waiting.front();
      waiting.pop_front();
      const std::optional<Diamond> d = diamond(e);
      if (!d || !angles_exceed_pi(places_, *d)) continue;
      if (!minimum_angle_rises(places_, *d) || !flip(*d)) {
        stuck_.push_back(e);
        continue;
      }
      ++counts_.flips;
      std::ranges::copy(rim(*d), std::back_inserter(waiting));
    }
    return Done{};
  }

  /// Between two diagonals that both are Delaunay, the one of better faces; no edge around may become failing by it.
  Status towards_better_shapes(const std::vector<Edge>& improvable) {
    std::deque<Edge> waiting(improvable.begin(), improvable.end());
    for (std::size_t step = 1; !waiting.empty(); ++step) {
      if (stop_at(step)) return cancelled();
      const std::optional<Diamond> d = diamond(waiting.front());
      waiting.pop_front();
      if (!d || angles_exceed_pi(places_, *d) || !is_better_turned(places_, *d)) continue;
      const std::size_t failing_before = failing_of(rim(*d));
      const std::size_t before = fans_.mark();
      if (!flip(*d)) continue;
      if (failing_of(rim(*d)) > failing_before) {
        fans_.undo(before);
        continue;
      }
      ++counts_.exchanges;
      std::ranges::copy(rim(*d), std::back_inserter(waiting));
    }
    return Done{};
  }

  bool stop_at(std::size_t step) const {
    constexpr std::size_t kStepsBetweenChecks = 4096;
    return step % kStepsBetweenChecks == 0 && context_.cancelled();
  }
  static Error cancelled() { return Error{ErrorCode::cancelled, "cancelled while edges were flipped"}; }

  static std::array<Edge, 4> rim(const Diamond& d) {
    return {Edge{d.a, d.right}, Edge{d.right, d.b}, Edge{d.b, d.left}, Edge{d.left, d.a}};
  }

  std::size_t failing_of(const std::array<Edge, 4>& edges) const {
    return static_cast<std::size_t>(std::ranges::count_if(edges, [&](const Edge& e) {
      const std::optional<Diamond> d = diamond(e);
      return d && angles_exceed_pi(places_, *d);
    }));
  }

  /// Both lists ascending. The pieces of parallel work do not show: the lists are sorted.
  Survey survey() const {
    std::mutex mutex;
    Survey all;
    parallel_ranges(context_.threads(), fans_.points(), [&](std::size_t begin, std::size_t end) {
      std::vector<Wedge> wedges;
      Survey here;
      for (std::size_t v = begin; v < end; ++v) survey_at(static_cast<std::uint32_t>(v), wedges, here);
      const std::scoped_lock lock(mutex);
      std::ranges::copy(here.failing, std::back_inserter(all.failing));
      std::ranges::copy(here.improvable, std::back_inserter(all.improvable));
    });
    for (std::vector<Edge>* list : {&all.failing, &all.improvable}) {
      std::ranges::sort(*list,
                        [](const Edge& x, const Edge& y) { return std::pair(x.from, x.to) < std::pair(y.from, y.to); });
    }
    return all;
  }

  void survey_at(std::uint32_t v, std::vector<Wedge>& wedges, Survey& found) const {
    fans_.copy_wedges(v, wedges);
    for (const Wedge& w : wedges) {
      if (w.first < v) continue;
      const auto other = std::ranges::find(wedges, w.first, &Wedge::second);
      if (other == wedges.end() || other->first == w.second) continue;
      const Diamond d{v, w.first, w.second, other->first};
      if (angles_exceed_pi(places_, d)) {
        found.failing.push_back({d.a, d.b});
      } else if (is_better_turned(places_, d)) {
        found.improvable.push_back({d.a, d.b});
      }
    }
  }

  std::optional<Diamond> diamond(Edge e) const {
    const std::uint32_t left = fans_.apex(e);
    const std::uint32_t right = fans_.apex({e.to, e.from});
    if (left == kNoVertex || right == kNoVertex || left == right) return std::nullopt;
    return Diamond{e.from, e.to, left, right};
  }

  /// Flips ab if that is valid.
  bool flip(const Diamond& d) {
    if (fans_.uses({d.left, d.right}) || fans_.uses({d.right, d.left})) return false;
    if (!places_.short_enough(d.left, d.right)) return false;
    if (!convex_in_the_mean_plane(places_, d)) return false;
    std::uint8_t& flips = flips_of_[key(d.a, d.b)];
    if (flips == kMostFlipsOfAnEdge) return false;
    const std::size_t before = fans_.mark();
    for (const Face& f : faces_before(d)) fans_.remove(f);
    for (const Face& f : faces_after(d)) {
      if (!legal(fans_, places_, f, kLeastCosine)) {
        fans_.undo(before);
        return false;
      }
      fans_.add(f);
    }
    ++flips;
    return true;
  }

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32U | std::max(a, b);
  }

  /// Of the edges that could not be flipped, those that are there and still fail.
  std::size_t still_failing() {
    std::vector<std::uint64_t> failing;
    for (const Edge& e : stuck_) {
      const std::optional<Diamond> d = diamond(e);
      if (d && angles_exceed_pi(places_, *d)) failing.push_back(key(e.from, e.to));
    }
    std::ranges::sort(failing);
    return static_cast<std::size_t>(std::unique(failing.begin(), failing.end()) - failing.begin());
  }

  Fans& fans_;
  Places& places_;
  Context& context_;
  FlipCounts counts_;
  std::vector<Edge> stuck_;
  std::unordered_map<std::uint64_t, std::uint8_t> flips_of_;
};

}  // namespace

bool angles_exceed_pi(const Point3& a, const Point3& b, const Point3& left, const Point3& right) {
  /// Sines this near to 0 are cocircular points within rounding: no flip.
  constexpr double kRoundingOfSine = 1e-12;
  const ApexAngle at_left(a, b, left);
  const ApexAngle at_right(a, b, right);
  // sin(α1 + α2) times all four lengths.
  const double sine = at_left.product * at_right.area + at_right.product * at_left.area;
  return sine < -kRoundingOfSine * at_left.lengths * at_right.lengths;
}

bool angles_exceed_pi(const Places& places, const Diamond& d) {
  return angles_exceed_pi(places.position(d.a), places.position(d.b), places.position(d.left),
                          places.position(d.right));
}

Result<FlipCounts> flip_edges(Fans& fans, Places& places, Context& context) {
  return Flipping(fans, places, context)();
}

Result<FlipCounts> flip_edges(TriangleMesh& mesh, Context& context) {
  if (mesh.positions.size() < 3) return FlipCounts{};
  try {
    front::AdoptedMesh adopted(mesh, context.threads());
    const Result<FlipCounts> counts = flip_edges(adopted.fans(), adopted.places(), context);
    if (counts && counts->flips + counts->exchanges > 0) mesh.triangles = adopted.fans().triangles();
    return counts;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "no memory left to flip edges of " + std::to_string(mesh.triangles.size()) + " triangles"};
  }
}

}  // namespace surfaced::idt
