// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/colouring.hpp"

#include <bit>
#include <cstdlib>
#include <queue>

namespace surfaced::boundary {
namespace {

struct Vote {
  std::int64_t strength;
  std::uint32_t cluster;
  friend bool operator<(const Vote& a, const Vote& b) {
    return a.strength != b.strength ? a.strength < b.strength : a.cluster > b.cluster;
  }
};

class Colouring {
 public:
  Colouring(const DelaunayComplex& complex, const RatedFacets& rated, const Clusters& clusters)
      : complex_(complex), rated_(rated), clusters_(clusters), votes_(complex.cells(), 0), in_(complex.cells(), 1) {
    // Cells of a cluster stand together; starts_ is by the cluster's least cell.
    starts_.assign(complex.cells() + 1, 0);
    for (const std::uint32_t cluster : clusters.cluster) ++starts_[cluster + 1];
    for (std::size_t c = 0; c < complex.cells(); ++c) starts_[c + 1] += starts_[c];
    cells_.resize(complex.cells());
    std::vector<std::uint32_t> cursor(starts_.begin(), starts_.end() - 1);
    for (std::size_t c = 0; c < complex.cells(); ++c) cells_[cursor[clusters.cluster[c]]++] = CellIndex(c);
  }

  std::vector<std::uint8_t> run(std::int64_t least_vote) {
    std::vector<std::uint8_t> labelled(complex_.cells(), 0);
    label(clusters_.outside, false, labelled);
    while (!queue_.empty()) {
      const Vote best = queue_.top();
      queue_.pop();
      if (labelled[best.cluster] != 0 || std::abs(votes_[best.cluster]) != best.strength) continue;
      if (best.strength < least_vote) break;
      label(best.cluster, votes_[best.cluster] > 0, labelled);
    }
    return std::move(in_);
  }

 private:
  /// Labels all cells of the cluster and votes against it in all clusters beyond its evidence.
  void label(std::uint32_t cluster, bool in, std::vector<std::uint8_t>& labelled) {
    labelled[cluster] = 1;
    std::vector<std::uint32_t> touched;
    for (std::size_t k = starts_[cluster]; k < starts_[cluster + 1]; ++k) {
      const CellIndex c = cells_[k];
      in_[c] = in ? 1 : 0;
      for (unsigned bits = rated_.evidence[c]; bits != 0; bits &= bits - 1) {
        const SideIndex side(4 * c + static_cast<std::size_t>(std::countr_zero(bits)));
        const std::uint32_t other = clusters_.cluster[complex_.neighbour(side)];
        if (labelled[other] != 0) continue;
        votes_[other] += in ? -rated_.weight(side) : rated_.weight(side);
        touched.push_back(other);
      }
    }
    for (const std::uint32_t other : touched) queue_.push({std::abs(votes_[other]), other});
  }

  const DelaunayComplex& complex_;
  const RatedFacets& rated_;
  const Clusters& clusters_;
  std::vector<std::uint32_t> starts_;
  std::vector<CellIndex> cells_;
  /// At a cluster's least cell: evidence for IN minus evidence for OUT.
  std::vector<std::int64_t> votes_;
  std::vector<std::uint8_t> in_;
  std::priority_queue<Vote> queue_;
};

}  // namespace

std::vector<std::uint8_t> parity_colouring(const DelaunayComplex& complex, const RatedFacets& rated,
                                           const Clusters& clusters, float least_vote) {
  return Colouring(complex, rated, clusters).run(FacetRatings::step_of(least_vote));
}

}  // namespace surfaced::boundary
