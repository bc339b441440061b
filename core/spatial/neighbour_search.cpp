// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/lanes.hpp"
#include "spatial/spatial.hpp"

namespace surfaced {
namespace {

using lanes::Doubles;
using lanes::Floats;
using lanes::kLanes;

/// Local coordinates lie within a cube of side 2.
constexpr double kLargestLocal2 = 12;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::size_t padded(std::size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

/// Coordinates of the points gathered; all arrays are padded to whole lanes.
struct Gathered {
  const double* x;
  const double* y;
  const double* z;
  std::size_t count;
};

/// Squared distances to q, and those at most `limit` with their positions. @return how many.
SURFACED_INLINE std::size_t scan_body(const Gathered& points, const Point3& q, float limit, std::uint32_t* hits,
                                      float* hit_distance2) {
  Doubles qx;
  Doubles qy;
  Doubles qz;
  lanes::fill(q[0], qx);
  lanes::fill(q[1], qy);
  lanes::fill(q[2], qz);
  std::size_t n = 0;
  for (std::size_t j = 0; j < points.count; j += kLanes) {
    Doubles x;
    Doubles y;
    Doubles z;
    lanes::load(points.x + j, x);
    lanes::load(points.y + j, y);
    lanes::load(points.z + j, z);
    x -= qx;
    y -= qy;
    z -= qz;
    const Floats d = __builtin_convertvector(x * x + y * y + z * z, Floats);
    // Written whether it counts or not: which points are near is anybody's guess, and branches on it are wrong often.
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      hits[n] = static_cast<std::uint32_t>(j + lane);
      hit_distance2[n] = d[lane];
      n += d[lane] <= limit ? 1U : 0U;
    }
  }
  return n;
}

SURFACED_TARGET_AVX2 std::size_t scan_wide(const Gathered& points, const Point3& q, float limit, std::uint32_t* hits,
                                           float* hit_distance2) {
  return scan_body(points, q, limit, hits, hit_distance2);
}
std::size_t scan_narrow(const Gathered& points, const Point3& q, float limit, std::uint32_t* hits,
                        float* hit_distance2) {
  return scan_body(points, q, limit, hits, hit_distance2);
}

/// How many of the values (padded with infinity) are at most `limit`.
std::size_t count_at_most(const float* values, std::size_t count, float limit) {
  lanes::Counts counts{};
  for (std::size_t j = 0; j < count; j += kLanes) {
    Floats v;
    lanes::load(values + j, v);
    lanes::count_at_most(v, limit, counts);
  }
  return static_cast<std::size_t>(counts[0] + counts[1] + counts[2] + counts[3]);
}

/// A value that exactly k of the values do not exceed, or, where ties leave none, the k-th smallest.
/// Distances squared around a point of a surface are spread evenly, so a guess by proportion is near.
float threshold(const float* values, std::size_t count, std::size_t k, float largest) {
  float low = -1;  // too few are at most this
  std::size_t below = 0;
  float high = largest;
  std::size_t above = count;
  for (int step = 0; above != k; ++step) {
    const float share = static_cast<float>(k - below) / static_cast<float>(above - below);
    constexpr int kGuesses = 6;
    float middle = std::max(low, 0.0F) + share * (high - std::max(low, 0.0F));
    if (step >= kGuesses) {
      // Bisection on the bits ends within 32 steps whatever the values are.
      const auto a = low < 0 ? std::int64_t{-1} : std::int64_t{std::bit_cast<std::int32_t>(low)};
      const auto b = std::int64_t{std::bit_cast<std::int32_t>(high)};
      if (b - a <= 1) break;
      middle = std::bit_cast<float>(static_cast<std::int32_t>((a + b) / 2));
    }
    if (!(middle > low && middle < high)) {
      if (step >= kGuesses) break;
      continue;
    }
    const std::size_t n = count_at_most(values, count, middle);
    if (n >= k) {
      high = middle;
      above = n;
    } else {
      low = middle;
      below = n;
    }
  }
  return high;
}

}  // namespace

void NeighbourSearch::gather(const BoxTree::Box& box, float radius) {
  box_ = box;
  radius_ = radius;
  near_leaves_.clear();
  tree_.leaves_near(box, radius, near_leaves_);
  gathered_ = 0;
  for (const std::uint32_t leaf : near_leaves_) gathered_ += tree_.first_point(leaf + 1) - tree_.first_point(leaf);
  const std::size_t size = padded(gathered_);
  if (index_.size() < size) {
    for (auto* array : {&x_, &y_, &z_}) array->resize(size);
    index_.resize(size);
    distance2_.resize(size);
    hits_.resize(size + kLanes);
    hit_distance2_.resize(size + kLanes);
  }
  std::size_t n = 0;
  for (const std::uint32_t leaf : near_leaves_) {
    for (std::size_t v = tree_.first_point(leaf); v < tree_.first_point(leaf + 1); ++v, ++n) {
      const Point3 p = tree_.local(v);
      x_[n] = p[0];
      y_[n] = p[1];
      z_[n] = p[2];
      index_[n] = static_cast<std::uint32_t>(v);
    }
  }
  for (; n < size; ++n) x_[n] = y_[n] = z_[n] = std::numeric_limits<double>::infinity();
}

void NeighbourSearch::begin_leaf(std::size_t leaf, std::size_t k) {
  constexpr float kMargin = 1.05F;
  largest_ = 0;
  previous_distance_ = -1;
  const BoxTree::Box& box = tree_.leaf_box(leaf);
  if (expected_radius_ > 0) {
    gather(box, expected_radius_ * kMargin);
    return;
  }
  float diagonal2 = 0;
  for (std::size_t i = 0; i < 3; ++i) diagonal2 += (box.high[i] - box.low[i]) * (box.high[i] - box.low[i]);
  gather(box, std::sqrt(diagonal2));
  while (gathered_ < std::min(k + 1, tree_.points())) {
    gather(box, std::max(2 * radius_, std::numeric_limits<float>::min()));
  }
}

void NeighbourSearch::keep(std::size_t v, const Point3& q, std::size_t candidate, Neighbours& result) const {
  if (index_[candidate] == v) return;
  const std::size_t n = result.count++;
  result.index[n] = index_[candidate];
  result.x[n] = x_[candidate] - q[0];
  result.y[n] = y_[candidate] - q[1];
  result.z[n] = z_[candidate] - q[2];
  result.distance2[n] = result.x[n] * result.x[n] + result.y[n] * result.y[n] + result.z[n] * result.z[n];
}

namespace {

void make_room(Neighbours& result, std::size_t count) {
  result.count = 0;
  const std::size_t size = padded(count);
  if (result.index.size() >= size) return;
  result.index.resize(size);
  for (auto* array : {&result.x, &result.y, &result.z, &result.distance2}) array->resize(size);
}

void pad(Neighbours& result) {
  for (std::size_t n = result.count; n < padded(result.count); ++n) {
    result.index[n] = VertexIndex::kNone;
    result.x[n] = result.y[n] = result.z[n] = result.distance2[n] = 0;
  }
}

}  // namespace

/// False if fewer than k+1 of the points gathered, v included, lie within the limit.
bool NeighbourSearch::try_nearest(std::size_t v, std::size_t k, float limit2, Neighbours& result) {
  const Gathered points{x_.data(), y_.data(), z_.data(), gathered_};
  const auto scan = lanes::wide_machine() ? scan_wide : scan_narrow;
  const Point3 q = tree_.local(v);
  const std::size_t n = scan(points, q, limit2, hits_.data(), hit_distance2_.data());
  if (n < k + 1) return false;
  for (std::size_t j = n; j < n + kLanes; ++j) hit_distance2_[j] = kInfinity;
  const float most = threshold(hit_distance2_.data(), n, k + 1, limit2);
  const std::size_t within = count_at_most(hit_distance2_.data(), n, most);
  std::size_t surplus = within - (k + 1);  // ties at `most`: those of the greatest indices are left out
  make_room(result, k + 1);
  if (surplus == 0) {
    for (std::size_t j = 0; j < n; ++j) {
      if (hit_distance2_[j] <= most) keep(v, q, hits_[j], result);
    }
  } else {
    std::size_t ties = 0;
    for (std::size_t j = 0; j < n; ++j) ties += hit_distance2_[j] == most ? 1U : 0U;
    for (std::size_t j = 0; j < n; ++j) {
      if (hit_distance2_[j] == most ? ties-- > surplus : hit_distance2_[j] < most) keep(v, q, hits_[j], result);
    }
  }
  pad(result);
  float furthest = 0;
  for (std::size_t j = 0; j < n; ++j) {
    if (hit_distance2_[j] <= most) furthest = std::max(furthest, hit_distance2_[j]);
  }
  const bool all = k + 1 == tree_.points();
  result.covered2 = all ? static_cast<double>(std::numeric_limits<float>::max()) : static_cast<double>(furthest);
  return true;
}

/// Radius that certainly is enough for v: the distance of its k-th neighbour among those gathered.
float NeighbourSearch::grown_radius(std::size_t v, std::size_t k) const {
  const Point3 q = tree_.local(v);
  std::vector<float> distances(gathered_);
  for (std::size_t j = 0; j < gathered_; ++j) {
    const Point3 d{x_[j] - q[0], y_[j] - q[1], z_[j] - q[2]};
    distances[j] = static_cast<float>(dot(d, d));
  }
  const auto kth = distances.begin() + static_cast<std::ptrdiff_t>(k);
  std::ranges::nth_element(distances, kth);
  constexpr float kSlack = 1 + 8 * std::numeric_limits<float>::epsilon();
  return std::max(std::sqrt(*kth) * kSlack, std::numeric_limits<float>::min());
}

void NeighbourSearch::nearest(std::size_t v, std::size_t k, Neighbours& result) {
  k = std::min(k, tree_.points() - 1);
  const Point3 q = tree_.local(v);
  float limit = radius_;
  if (previous_distance_ >= 0) {
    constexpr double kSlack = 1 + 1e-6;  // over the float's rounding; too small only costs a second scan
    limit = std::min(limit, static_cast<float>((previous_distance_ + norm(q - previous_)) * kSlack));
  }
  bool found = try_nearest(v, k, limit * limit, result);
  if (!found && limit < radius_) found = try_nearest(v, k, radius_ * radius_, result);
  while (!found) {
    const BoxTree::Box box = box_;
    if (gathered_ <= k) {
      gather(box, std::max(2 * radius_, std::numeric_limits<float>::min()));
    } else if (complete()) {
      found = try_nearest(v, k, std::numeric_limits<float>::max(), result);
    } else {
      gather(box, std::max(grown_radius(v, k), radius_));
      found = try_nearest(v, k, radius_ * radius_, result);
    }
  }
  previous_ = q;
  previous_distance_ = std::sqrt(std::min(result.covered2, kLargestLocal2));
  largest_ = std::max(largest_, static_cast<float>(previous_distance_));
  expected_radius_ = largest_;
}

void NeighbourSearch::gathered(std::size_t v, Neighbours& result) {
  const Gathered points{x_.data(), y_.data(), z_.data(), gathered_};
  const auto scan = lanes::wide_machine() ? scan_wide : scan_narrow;
  const float limit2 = complete() ? std::numeric_limits<float>::max() : radius_ * radius_;
  const Point3 q = tree_.local(v);
  const std::size_t n = scan(points, q, limit2, hits_.data(), hit_distance2_.data());
  make_room(result, n);
  for (std::size_t j = 0; j < n; ++j) keep(v, q, hits_[j], result);
  pad(result);
  result.covered2 = static_cast<double>(limit2);
}

void NeighbourSearch::nearest_anywhere(std::size_t v, std::size_t k, Neighbours& result) {
  k = std::min(k, tree_.points() - 1);
  const BoxTree::Box box = tree_.box_of(tree_.local(v));
  float radius = expected_radius_;
  if (!(radius > 0)) {
    const std::size_t other = v > 0 ? v - 1 : std::min<std::size_t>(1, tree_.points() - 1);
    constexpr double kFirstGuess = 3;
    radius = static_cast<float>(kFirstGuess * norm(tree_.local(other) - tree_.local(v)));
  }
  previous_distance_ = -1;
  largest_ = 0;
  gather(box, std::max(radius, std::numeric_limits<float>::min()));
  nearest(v, k, result);
}

}  // namespace surfaced
