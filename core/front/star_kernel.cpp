// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 2 (Bíscaro 2010), section 4; the star by inversion is the convex hull of q/D, where q is the
// projected neighbour and D decides the construction.
#include "front/star_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/lanes.hpp"

namespace surfaced::front {
namespace {

using lanes::Doubles;
using lanes::kLanes;
using lanes::Mask;

/// The weight's width, in mean distances.
constexpr double kWeightWidth = 0.75;
/// Below this ratio of the two larger eigenvalues the neighbours span a line.
constexpr double kLineRatio = 1e-4;

SURFACED_INLINE void root(Doubles& x) {
  for (unsigned i = 0; i < kLanes; ++i) x[i] = __builtin_sqrt(x[i]);
}

/// exp(-x) for x >= 0, to about 1e-9; made of IEEE operations only, unlike the C library's.
SURFACED_INLINE void exp_of_minus(Doubles& x) {
  constexpr double kLog2E = 1.4426950408889634;
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer in the low bits
  Doubles t = x * -kLog2E;
  const Doubles deepest{-1000, -1000, -1000, -1000};
  t = t < deepest ? deepest : t;
  const Doubles shifted = t + kShift;
  const Doubles f = (t - (shifted - kShift)) * 0.6931471805599453;
  Doubles p = f * (1.0 / 5040) + 1.0 / 720;
  p = p * f + 1.0 / 120;
  p = p * f + 1.0 / 24;
  p = p * f + 1.0 / 6;
  p = p * f + 0.5;
  p = p * f + 1.0;
  p = p * f + 1.0;
  Mask bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  bits = (bits + 1023) << 52;
  Doubles power;
  std::memcpy(&power, &bits, sizeof power);
  x = p * power;
}

/// Sum over the lanes in a fixed order.
SURFACED_INLINE double sum(const Doubles& x) { return (x[0] + x[1]) + (x[2] + x[3]); }

/// Weighted moments of the neighbours about the point.
struct Moments {
  double weight = 0;
  double mean_distance = 0;
  Point3 first{};
  std::array<double, 6> second{};  // xx, xy, xz, yy, yz, zz
};

SURFACED_INLINE void moments_body(const Neighbours& n, Moments& m) {
  Doubles total{};
  for (std::size_t j = 0; j < n.count; j += kLanes) {
    Doubles d;
    lanes::load(n.distance2.data() + j, d);
    root(d);
    total += d;
  }
  const double mean = sum(total) / static_cast<double>(n.count);
  const double inverse = 1 / (kWeightWidth * kWeightWidth * mean * mean);
  Doubles w0{};
  std::array<Doubles, 3> w1{};
  std::array<Doubles, 6> w2{};
  for (std::size_t j = 0; j < n.count; j += kLanes) {
    Doubles w;
    Doubles x;
    Doubles y;
    Doubles z;
    lanes::load(n.distance2.data() + j, w);
    lanes::load(n.x.data() + j, x);
    lanes::load(n.y.data() + j, y);
    lanes::load(n.z.data() + j, z);
    w *= inverse;
    exp_of_minus(w);
    w0 += w;
    const Doubles wx = w * x;
    const Doubles wy = w * y;
    const Doubles wz = w * z;
    w1[0] += wx;
    w1[1] += wy;
    w1[2] += wz;
    w2[0] += wx * x;
    w2[1] += wx * y;
    w2[2] += wx * z;
    w2[3] += wy * y;
    w2[4] += wy * z;
    w2[5] += wz * z;
  }
  // The lanes of padding have weight 1 and no extent; the point itself is the same.
  const std::size_t padding = (kLanes - n.count % kLanes) % kLanes;
  m.weight = sum(w0) - static_cast<double>(padding) + 1;
  m.mean_distance = mean;
  for (std::size_t i = 0; i < 3; ++i) m.first[i] = sum(w1[i]);
  for (std::size_t i = 0; i < 6; ++i) m.second[i] = sum(w2[i]);
}

SURFACED_TARGET_AVX2 void moments_wide(const Neighbours& n, Moments& m) { moments_body(n, m); }
void moments_narrow(const Neighbours& n, Moments& m) { moments_body(n, m); }

/// Root of l^3 - trace l^2 + minors l - determinant nearest to zero, for a matrix without negative
/// eigenvalues: Newton's steps from 0 never pass it.
double smallest_eigenvalue(double trace, double minors, double determinant) {
  constexpr int kSteps = 40;
  constexpr double kEnough = 1e-15;
  double l = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double value = ((l - trace) * l + minors) * l - determinant;
    const double slope = (3 * l - 2 * trace) * l + minors;
    if (!(value < 0) || !(slope > 0)) break;
    const double next = l - value / slope;
    if (!(next > l) || next - l <= kEnough * trace) return next > l ? next : l;
    l = next;
  }
  return l;
}

/// Direction in the kernel of the matrix minus its smallest eigenvalue: the longest cross product of rows.
Point3 kernel_direction(const std::array<double, 6>& c, double l) {
  const std::array<Point3, 3> rows{Point3{c[0] - l, c[1], c[2]}, Point3{c[1], c[3] - l, c[4]},
                                   Point3{c[2], c[4], c[5] - l}};
  Point3 best = cross(rows[0], rows[1]);
  for (const Point3& other : {cross(rows[0], rows[2]), cross(rows[1], rows[2])}) {
    if (dot(other, other) > dot(best, best)) best = other;
  }
  return best;
}

/// Any unit vector across the longest axis of the matrix: for neighbours along a line.
Point3 across(const std::array<double, 6>& c) {
  const std::array<Point3, 3> rows{Point3{c[0], c[1], c[2]}, Point3{c[1], c[3], c[4]}, Point3{c[2], c[4], c[5]}};
  const Point3 along = *std::ranges::max_element(rows, {}, [](const Point3& row) { return dot(row, row); });
  Point3 axis{};
  std::size_t least = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(along[i]) < std::abs(along[least])) least = i;
  }
  axis[least] = 1;
  const Point3 n = cross(along, axis);
  const double length = norm(n);
  if (!(length > 0)) return {0, 0, 1};
  return {n[0] / length, n[1] / length, n[2] / length};
}

}  // namespace

Tangent tangent_of(const Neighbours& neighbours) {
  Moments m;
  (lanes::wide_machine() ? moments_wide : moments_narrow)(neighbours, m);
  Tangent tangent;
  tangent.spacing = m.mean_distance;
  // In units of the spacing, so that no product of a tiny neighbourhood underflows.
  const double unit = 1 / (m.weight * m.mean_distance * m.mean_distance);
  std::array<double, 6> c{};
  for (std::size_t i = 0, k = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j, ++k) c[k] = (m.second[k] - m.first[i] * m.first[j] / m.weight) * unit;
  }
  const double trace = c[0] + c[3] + c[5];
  const double minors = (c[0] * c[3] - c[1] * c[1]) + (c[0] * c[5] - c[2] * c[2]) + (c[3] * c[5] - c[4] * c[4]);
  const double determinant =
      c[0] * (c[3] * c[5] - c[4] * c[4]) - c[1] * (c[1] * c[5] - c[4] * c[2]) + c[2] * (c[1] * c[4] - c[3] * c[2]);
  const double l = smallest_eigenvalue(trace, minors, determinant);
  const double others = trace - l;
  tangent.thickness = others > 0 ? l / others : 0;
  tangent.certain = minors - l * others > kLineRatio * others * others;
  const Point3 n = kernel_direction(c, l);
  const double length = norm(n);
  if (tangent.certain && length > 0) {
    tangent.normal = {n[0] / length, n[1] / length, n[2] / length};
  } else {
    tangent.certain = false;
    tangent.normal = across(c);
  }
  return tangent;
}

namespace {

/// Orthonormal basis of the plane across a unit vector (Duff et al. 2017).
struct Plane {
  explicit Plane(const Point3& n) {
    const double sign = std::copysign(1.0, n[2]);
    const double a = -1 / (sign + n[2]);
    const double b = n[0] * n[1] * a;
    u = {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
    v = {b, sign + n[1] * n[1] * a, -n[1]};
  }
  Point3 u;
  Point3 v;
};

/// A number in [0, 1) that belongs to the vertex.
double tie_breaker(std::uint32_t v) {
  std::uint32_t h = v * 2654435761U;
  h ^= h >> 15U;
  h *= 2246822519U;
  return static_cast<double>(h >> 8U) * 0x1p-24;
}

/// Neighbours by inversion: x, y of q/D, zeros in the padding and where D is not positive.
template <StarKind kind>
SURFACED_INLINE void invert_body(const Neighbours& n, const Plane& plane, double tie_scale, StarScratch& s) {
  for (std::size_t j = 0; j < n.count; j += kLanes) {
    Doubles x;
    Doubles y;
    Doubles z;
    Doubles d;
    Doubles tie;
    lanes::load(n.x.data() + j, x);
    lanes::load(n.y.data() + j, y);
    lanes::load(n.z.data() + j, z);
    lanes::load(n.distance2.data() + j, d);
    lanes::load(s.tie.data() + j, tie);
    const Doubles qx = x * plane.u[0] + y * plane.u[1] + z * plane.u[2];
    const Doubles qy = x * plane.v[0] + y * plane.v[1] + z * plane.v[2];
    if constexpr (kind == StarKind::projected) d = qx * qx + qy * qy;
    if constexpr (kind == StarKind::unfolded) {
      d *= qx * qx + qy * qy;
      root(d);
    }
    d += tie * tie_scale;
    const Doubles zero{};
    const Doubles one{1, 1, 1, 1};
    const Doubles inverse = d > zero ? one / (d > zero ? d : one) : zero;
    lanes::store(qx * inverse, s.x.data() + j);
    lanes::store(qy * inverse, s.y.data() + j);
  }
}

/// The next corner of the hull after `from`, counter-clockwise (side 1) or clockwise (side -1): the largest
/// angle of the papers. @return the count where all others lie on the wrong side.
SURFACED_INLINE std::size_t next_body(const StarScratch& s, std::size_t count, std::size_t from, double side) {
  Doubles ax;
  Doubles ay;
  lanes::fill(s.x[from], ax);
  lanes::fill(s.y[from], ay);
  Doubles best_out{-1, -1, -1, -1};
  Doubles best_along{};
  Doubles best_at{-1, -1, -1, -1};
  Doubles at{0, 1, 2, 3};
  const Doubles zero{};
  for (std::size_t j = 0; j < count; j += kLanes, at += 4.0) {
    Doubles x;
    Doubles y;
    lanes::load(s.x.data() + j, x);
    lanes::load(s.y.data() + j, y);
    const Doubles ex = x - ax;
    const Doubles ey = y - ay;
    const Doubles out = ex * ax + ey * ay;
    const Doubles along = (ey * ax - ex * ay) * side;
    const Mask better = (along > zero) & (out * best_along > best_out * along);
    best_out = better ? out : best_out;
    best_along = better ? along : best_along;
    best_at = better ? at : best_at;
  }
  std::size_t found = count;
  double out = 0;
  double along = 0;
  for (unsigned lane = 0; lane < kLanes; ++lane) {
    if (best_at[lane] < 0) continue;
    const auto candidate = static_cast<std::size_t>(best_at[lane]);
    const double left = best_out[lane] * along;
    const double right = out * best_along[lane];
    if (found < count && !(left > right || (left == right && candidate < found))) continue;
    found = candidate;
    out = best_out[lane];
    along = best_along[lane];
  }
  return found;
}

SURFACED_INLINE void invert_any(const Neighbours& n, const Plane& plane, double tie_scale, StarKind kind,
                                StarScratch& s) {
  if (kind == StarKind::restricted) invert_body<StarKind::restricted>(n, plane, tie_scale, s);
  if (kind == StarKind::unfolded) invert_body<StarKind::unfolded>(n, plane, tie_scale, s);
  if (kind == StarKind::projected) invert_body<StarKind::projected>(n, plane, tie_scale, s);
}

/// Corner that is certainly on the hull: the farthest from the centre.
std::size_t first_corner(const StarScratch& s, std::size_t count) {
  std::size_t best = 0;
  double best_length = -1;
  for (std::size_t j = 0; j < count; ++j) {
    const double length = s.x[j] * s.x[j] + s.y[j] * s.y[j];
    if (length > best_length) {
      best_length = length;
      best = j;
    }
  }
  return best;
}

/// Walks the hull from its first corner to both sides.
SURFACED_INLINE void wrap_body(const StarScratch& s, std::size_t count, Star& star) {
  star.count = 0;
  star.closed = false;
  const std::size_t start = first_corner(s, count);
  const auto listed = [&](std::size_t corner) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < star.count; ++i) {
      if (star.corners[i] == corner) return true;
    }
    return false;
  };
  bool repeated = false;
  for (std::size_t at = start; at < count;) {
    star.corners[star.count++] = static_cast<std::uint32_t>(at);
    if (star.count == LocalStars::kLongestStar) return;
    at = next_body(s, count, at, 1);
    if (at < count && listed(at)) {
      star.closed = at == start && star.count > 2;
      repeated = !star.closed;
      break;
    }
  }
  if (star.closed || repeated) return;
  const std::size_t forward = star.count;
  for (std::size_t at = next_body(s, count, start, -1); at < count && star.count < LocalStars::kLongestStar;) {
    if (listed(at)) break;
    star.corners[star.count++] = static_cast<std::uint32_t>(at);
    at = next_body(s, count, at, -1);
  }
  // Now start, forward corners, backward corners: turn it into one counter-clockwise list.
  std::rotate(star.corners.begin(), star.corners.begin() + static_cast<std::ptrdiff_t>(forward),
              star.corners.begin() + static_cast<std::ptrdiff_t>(star.count));
  std::reverse(star.corners.begin(), star.corners.begin() + static_cast<std::ptrdiff_t>(star.count - forward));
}

SURFACED_INLINE void star_body(const Neighbours& n, const Plane& plane, double tie_scale, StarKind kind, StarScratch& s,
                               Star& star) {
  invert_any(n, plane, tie_scale, kind, s);
  wrap_body(s, n.count, star);
}

SURFACED_TARGET_AVX2 void star_wide(const Neighbours& n, const Plane& plane, double tie_scale, StarKind kind,
                                    StarScratch& s, Star& star) {
  star_body(n, plane, tie_scale, kind, s, star);
}
void star_narrow(const Neighbours& n, const Plane& plane, double tie_scale, StarKind kind, StarScratch& s, Star& star) {
  star_body(n, plane, tie_scale, kind, s, star);
}

/// Whether all corners of the Voronoi cell are nearer than half of what the neighbours cover.
bool certain(const StarScratch& s, const Star& star, double covered2) {
  if (!star.closed) return false;
  for (std::size_t i = 0; i < star.count; ++i) {
    const std::size_t a = star.corners[i];
    const std::size_t b = star.corners[i + 1 < star.count ? i + 1 : 0];
    const double area = s.x[a] * s.y[b] - s.x[b] * s.y[a];
    const double dx = s.x[a] - s.x[b];
    const double dy = s.y[a] - s.y[b];
    if (!(dx * dx + dy * dy <= area * area * covered2)) return false;
  }
  return true;
}

}  // namespace

void star_of(std::size_t v, const Neighbours& neighbours, const Tangent& tangent, StarKind kind, StarScratch& scratch,
             Star& star) {
  // Ties: points on a common circle, as in grids. Where the surface curves, the planes of the three vertices
  // decide them differently, so the push grows with the thickness; in a plane it only has to exceed rounding.
  constexpr double kLeastPush = 1e-12;
  constexpr double kLargestPush = 1e-4;
  const double push = std::min(kLeastPush + tangent.thickness, kLargestPush) * tangent.spacing * tangent.spacing;
  const std::size_t size = (neighbours.count + kLanes - 1) / kLanes * kLanes;
  for (auto* array : {&scratch.x, &scratch.y, &scratch.tie}) {
    if (array->size() < size) array->resize(size);
  }
  const double own = tie_breaker(static_cast<std::uint32_t>(v));
  for (std::size_t j = 0; j < neighbours.count; ++j) scratch.tie[j] = tie_breaker(neighbours.index[j]) - own;
  for (std::size_t j = neighbours.count; j < size; ++j) scratch.tie[j] = 0;
  (lanes::wide_machine() ? star_wide : star_narrow)(neighbours, Plane(tangent.normal), push, kind, scratch, star);
  star.certain = certain(scratch, star, neighbours.covered2);
}

}  // namespace surfaced::front
