// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/local_stars.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "base/parallel.hpp"
#include "front/star_kernel.hpp"

namespace surfaced::front {

/// Makes the stars of one block after the other; one per thread and block.
class StarMaker {
 public:
  StarMaker(const BoxTree& tree, const StarParameters& parameters, LocalStars& stars)
      : tree_(tree), parameters_(parameters), stars_(stars), near_(tree), far_(tree) {}

  void operator()(std::size_t block) {
    for (std::size_t leaf = tree_.first_leaf(block); leaf < tree_.first_leaf(block + 1); ++leaf) {
      near_.begin_leaf(leaf, parameters_.neighbours);
      for (std::size_t v = tree_.first_point(leaf); v < tree_.first_point(leaf + 1); ++v) make(v);
    }
    stars_.blocks_[block].assign(list_.begin(), list_.end());
  }

 private:
  /// First few neighbours, then all that were gathered anyway, then many.
  void make(std::size_t v) {
    constexpr std::size_t kMany = 48;
    near_.nearest(v, parameters_.neighbours, neighbours_);
    if (parameters_.spacings) stars_.spacings[v] = spacing_of(neighbours_);
    Tangent tangent = tangent_of(neighbours_);
    if (tangent.certain) {
      star_of(v, neighbours_, tangent, parameters_.kind, scratch_, star_);
      if (!star_.certain) {
        near_.gathered(v, neighbours_);
        star_of(v, neighbours_, tangent, parameters_.kind, scratch_, star_);
      }
    }
    if (!tangent.certain || !star_.certain) {
      far_.nearest_anywhere(v, std::max(kMany, parameters_.neighbours * 3 / 2), neighbours_);
      if (!tangent.certain) tangent = tangent_of(neighbours_);
      star_of(v, neighbours_, tangent, parameters_.kind, scratch_, star_);
    }
    store(v, tangent);
  }

  /// Distance of the 6th nearest, or of the farthest if there are fewer.
  static float spacing_of(const Neighbours& neighbours) {
    constexpr std::size_t kRank = 6;
    std::array<double, kRank> nearest;
    std::size_t kept = 0;
    for (std::size_t j = 0; j < neighbours.count; ++j) {
      const double d = neighbours.distance2[j];
      if (kept == kRank && d >= nearest.back()) continue;
      std::size_t at = kept < kRank ? kept++ : kRank - 1;
      for (; at > 0 && nearest[at - 1] > d; --at) nearest[at] = nearest[at - 1];
      nearest[at] = d;
    }
    return kept > 0 ? static_cast<float>(std::sqrt(nearest[kept - 1])) : 0;
  }

  void store(std::size_t v, const Tangent& tangent) {
    stars_.normals[v] = {static_cast<float>(tangent.normal[0]), static_cast<float>(tangent.normal[1]),
                         static_cast<float>(tangent.normal[2])};
    stars_.headers_[v] = {static_cast<std::uint16_t>(list_.size()), static_cast<std::uint8_t>(star_.count),
                          star_.closed};
    for (std::size_t i = 0; i < star_.count; ++i) list_.push_back(neighbours_.index[star_.corners[i]]);
  }

  const BoxTree& tree_;
  const StarParameters& parameters_;
  LocalStars& stars_;
  NeighbourSearch near_;
  NeighbourSearch far_;
  Neighbours neighbours_;
  StarScratch scratch_;
  Star star_{};
  std::vector<std::uint32_t> list_;

 public:
  static std::vector<std::vector<std::uint32_t>>& blocks(LocalStars& stars) { return stars.blocks_; }
};

void LocalStars::turn_over(std::size_t v) {
  for (float& x : normals[v]) x = -x;
  std::uint32_t* first = blocks_[v / BoxTree::kPointsPerBlock].data() + headers_[v].start;
  std::reverse(first, first + headers_[v].count);
}

Result<LocalStars> local_stars(const BoxTree& tree, const StarParameters& parameters, Context& context) {
  LocalStars stars(tree.points());
  StarMaker::blocks(stars).resize(tree.blocks());
  if (parameters.spacings) stars.spacings.resize(tree.points());
  std::atomic<std::size_t> done{0};
  parallel_tasks(context.threads(), tree.blocks(), [&](std::size_t block) {
    if (context.cancelled()) return;
    StarMaker(tree, parameters, stars)(block);
    context.report(static_cast<double>(++done) / static_cast<double>(tree.blocks()));
  });
  if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while local triangulations were made"};
  return stars;
}

}  // namespace surfaced::front
