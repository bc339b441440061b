// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "spatial/spatial.hpp"

namespace surfaced {
namespace {

constexpr std::size_t kTasksPerPiece = 64;

float rounded_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

float rounded_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

BoxTree::Box united(const BoxTree::Box& a, const BoxTree::Box& b) {
  BoxTree::Box box = a;
  for (std::size_t i = 0; i < 4; ++i) {
    box.low[i] = std::min(a.low[i], b.low[i]);
    box.high[i] = std::max(a.high[i], b.high[i]);
  }
  return box;
}

/// Squared distance between boxes. Rounding may make it too great by a few units in the last place, which
/// the caller makes up for in the radius.
float distance2(const BoxTree::Box& a, const BoxTree::Box& b) {
  float sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const float gap = std::max(std::max(a.low[i] - b.high[i], b.low[i] - a.high[i]), 0.0F);
    sum += gap * gap;
  }
  return sum;
}

/// Runs the task for 0..count-1 in pieces large enough for a thread.
template <class Task>
void in_pieces(unsigned threads, std::size_t count, Task&& task) {
  const std::size_t pieces = (count + kTasksPerPiece - 1) / kTasksPerPiece;
  parallel_tasks(threads, pieces, [&](std::size_t piece) {
    const std::size_t end = std::min(count, (piece + 1) * kTasksPerPiece);
    for (std::size_t k = piece * kTasksPerPiece; k < end; ++k) task(k);
  });
}

}  // namespace

BoxTree::BoxTree(std::span<const Point3> positions, unsigned threads) : positions_(positions) {
  if (positions.empty()) {
    first_ = block_leaf_ = {0};
    return;
  }
  Point3 high = low_ = positions.front();
  for (const Point3& p : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low_[axis] = std::min(low_[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  const double side = std::ranges::max(high - low_);
  int exponent = 1;
  std::frexp(side, &exponent);
  scale_ = std::ldexp(1.0, std::clamp(1 - exponent, -1000, 1000));
  cut_leaves(threads);
  build_boxes(threads);
}

/// A leaf ends where the step to the next point is long, so that it does not span a jump of the curve.
void BoxTree::cut_leaves(unsigned threads) {
  const std::size_t block_count = (points() + kPointsPerBlock - 1) / kPointsPerBlock;
  std::vector<std::vector<std::uint32_t>> cuts(block_count);
  parallel_tasks(threads, block_count, [&](std::size_t block) {
    std::size_t begin = block * kPointsPerBlock;
    const std::size_t end = std::min(points(), begin + kPointsPerBlock);
    cuts[block].reserve(kPointsPerBlock / 8);
    while (begin < end) {
      cuts[block].push_back(static_cast<std::uint32_t>(begin));
      if (end - begin <= kLargestLeaf) break;
      double best = -1;
      std::size_t cut = begin + kLargestLeaf;
      for (std::size_t v = begin + 1; v <= begin + kLargestLeaf; ++v) {
        const Point3 step = (positions_[v] - positions_[v - 1]);
        const Point3 scaled{step[0] * scale_, step[1] * scale_, step[2] * scale_};
        const double score = dot(scaled, scaled) * static_cast<double>((v - begin) * (v - begin));
        if (score >= best) {
          best = score;
          cut = v;
        }
      }
      begin = cut;
    }
  });
  std::size_t count = 0;
  for (const auto& list : cuts) count += list.size();
  first_.reserve(count + 1);
  block_leaf_.reserve(block_count + 1);
  for (const auto& list : cuts) {
    block_leaf_.push_back(static_cast<std::uint32_t>(first_.size()));
    first_.insert(first_.end(), list.begin(), list.end());
  }
  block_leaf_.push_back(static_cast<std::uint32_t>(first_.size()));
  first_.push_back(static_cast<std::uint32_t>(points()));
}

void BoxTree::build_boxes(unsigned threads) {
  levels_.emplace_back(leaves());
  in_pieces(threads, leaves(), [&](std::size_t leaf) {
    Box box = box_of(local(first_[leaf]));
    for (std::size_t v = first_[leaf] + 1; v < first_[leaf + 1]; ++v) box = united(box, box_of(local(v)));
    levels_.front()[leaf] = box;
  });
  while (levels_.back().size() > 1) {
    const std::vector<Box>& below = levels_.back();
    std::vector<Box> level((below.size() + 1) / 2);
    for (std::size_t i = 0; i < level.size(); ++i) {
      level[i] = 2 * i + 1 < below.size() ? united(below[2 * i], below[2 * i + 1]) : below[2 * i];
    }
    levels_.push_back(std::move(level));
  }
}

BoxTree::Box BoxTree::box_of(const Point3& local) const {
  Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = rounded_down(local[axis]);
    box.high[axis] = rounded_up(local[axis]);
  }
  return box;
}

void BoxTree::leaves_near(const Box& box, float radius, std::vector<std::uint32_t>& leaves) const {
  if (points() == 0) return;
  // A few roundings of the squared distance, each half a unit in the last place.
  constexpr float kSlack = 1 + 16 * std::numeric_limits<float>::epsilon();
  const float limit = radius * radius * kSlack + std::numeric_limits<float>::min();
  struct Node {
    std::uint32_t level;
    std::uint32_t at;
  };
  std::array<Node, 72> stack;  // two per level are enough, and there are at most 32 levels
  std::size_t height = 0;
  stack[height++] = {static_cast<std::uint32_t>(levels_.size() - 1), 0};
  while (height > 0) {
    const Node node = stack[--height];
    if (!(distance2(levels_[node.level][node.at], box) <= limit)) continue;
    if (node.level == 0) {
      leaves.push_back(node.at);
      continue;
    }
    const std::uint32_t below = node.level - 1;
    if (2 * std::size_t{node.at} + 1 < levels_[below].size()) stack[height++] = {below, 2 * node.at + 1};
    stack[height++] = {below, 2 * node.at};
  }
}

}  // namespace surfaced
