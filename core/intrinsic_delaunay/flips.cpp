#include "intrinsic_delaunay/flips.hpp"

#include <algorithm>
#include <deque>
#include <iterator>
#include <limits>
#include <mutex>
#include <unordered_map>

#include "base/parallel.hpp"

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
    const std::vector<Edge> found = failing_edges();
    std::deque<Edge> waiting(found.begin(), found.end());
    constexpr std::size_t kStepsBetweenChecks = 4096;
    for (std::size_t step = 1; !waiting.empty(); ++step) {
      if (step % kStepsBetweenChecks == 0 && context_.cancelled())
        return Error{ErrorCode::cancelled, "cancelled while edges were flipped"};
      const Edge e = waiting.front();
      waiting.pop_front();
      const std::optional<Diamond> d = diamond(e);
      if (!d || !angles_exceed_pi(places_, *d)) continue;
      if (!flip(*d)) {
        stuck_.push_back(e);
        continue;
      }
      ++counts_.flips;
      for (const Edge rim : {Edge{d->a, d->right}, Edge{d->right, d->b}, Edge{d->b, d->left}, Edge{d->left, d->a}})
        waiting.push_back(rim);
    }
    counts_.not_flippable = still_failing();
    return counts_;
  }

 private:
  /// Edges with α1 + α2 > π, ascending. The pieces of parallel work do not show: the list is sorted.
  std::vector<Edge> failing_edges() const {
    std::mutex mutex;
    std::vector<Edge> all;
    parallel_ranges(context_.threads(), fans_.points(), [&](std::size_t begin, std::size_t end) {
      std::vector<Wedge> wedges;
      std::vector<Edge> here;
      for (std::size_t v = begin; v < end; ++v) {
        fans_.copy_wedges(static_cast<std::uint32_t>(v), wedges);
        for (const Wedge& w : wedges) {
          if (w.first < v) continue;
          const auto other = std::ranges::find(wedges, w.first, &Wedge::second);
          if (other == wedges.end()) continue;
          const Diamond d{static_cast<std::uint32_t>(v), w.first, w.second, other->first};
          if (angles_exceed_pi(places_, d)) here.push_back({d.a, d.b});
        }
      }
      const std::scoped_lock lock(mutex);
      std::ranges::copy(here, std::back_inserter(all));
    });
    std::ranges::sort(all,
                      [](const Edge& x, const Edge& y) { return std::pair(x.from, x.to) < std::pair(y.from, y.to); });
    return all;
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
    if (!convex_in_the_mean_plane(places_, d) || !minimum_angle_rises(places_, d)) return false;
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
    const auto repeated = std::ranges::unique(failing);
    return failing.size() - repeated.size();
  }

  Fans& fans_;
  Places& places_;
  Context& context_;
  FlipCounts counts_;
  std::vector<Edge> stuck_;
  std::unordered_map<std::uint64_t, std::uint8_t> flips_of_;
};

}  // namespace

bool angles_exceed_pi(const Places& places, const Diamond& d) {
  /// Sines this near to 0 are cocircular points within rounding: no flip.
  constexpr double kRoundingOfSine = 1e-12;
  const Point3 a = places.position(d.a);
  const Point3 b = places.position(d.b);
  const ApexAngle left(a, b, places.position(d.left));
  const ApexAngle right(a, b, places.position(d.right));
  // sin(α1 + α2) times all four lengths.
  const double sine = left.product * right.area + right.product * left.area;
  return sine < -kRoundingOfSine * left.lengths * right.lengths;
}

Result<FlipCounts> flip_edges(Fans& fans, Places& places, Context& context) {
  return Flipping(fans, places, context)();
}

}  // namespace surfaced::idt
