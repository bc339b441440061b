// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/facet_queue.hpp"

#include <algorithm>
#include <bit>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

/// Bits of the key that choose the bucket: exponent and three bits of the mantissa.
constexpr unsigned kBucketShift = 20;
constexpr std::size_t kBuckets = std::size_t{1} << (32 - kBucketShift);
/// The rest is sorted in two passes.
constexpr unsigned kDigitBits = 10;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
/// Facets looked up at once; a block may grow by facets of the same key.
constexpr std::size_t kQueueBlock = 256;

}  // namespace

FacetQueue::FacetQueue(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads)
    : complex_(complex), criterion_(criterion), ends_(kBuckets, 0) {
  struct Part {
    std::vector<Keyed> keyed;
    std::vector<std::size_t> starts = std::vector<std::size_t>(kBuckets, 0);
  };
  std::vector<Part> parts(threads);
  parallel_tasks(threads, threads, [&](std::size_t p) {
    Part& part = parts[p];
    const std::size_t begin = complex.cells() * p / threads;
    const std::size_t end = complex.cells() * (p + 1) / threads;
    part.keyed.reserve(2 * (end - begin) + 2 * (end - begin) / 16);
    for (std::size_t c = begin; c < end; ++c) {
      const unsigned first = complex.infinite(CellIndex(c)) ? 3 : 0;
      for (std::size_t s = 4 * c + first; s < 4 * c + 4; ++s) {
        if (s > complex.mate(s)) continue;
        // Rounding to float is monotone, and the bits of non-negative floats ascend with their values.
        const auto key = std::bit_cast<std::uint32_t>(static_cast<float>(criterion.squared(SideIndex(s))));
        part.keyed.push_back({key, SideIndex(s)});
        ++part.starts[key >> kBucketShift];
      }
    }
  });
  std::size_t count = 0;
  for (std::size_t b = 0; b < kBuckets; ++b) {
    for (Part& part : parts) {
      const std::size_t size = part.starts[b];
      part.starts[b] = count;
      count += size;
    }
    ends_[b] = count;
  }
  facets_.resize(count);
  parallel_tasks(threads, threads, [&](std::size_t p) {
    for (const Keyed& k : parts[p].keyed) facets_[parts[p].starts[k.key >> kBucketShift]++] = k;
    parts[p].keyed = {};
  });
}

std::span<const ListedFacet> FacetQueue::next_block() {
  if (next_ == sorted_) sort_next_bucket();
  std::size_t end = std::min(next_ + kQueueBlock, sorted_);
  while (end < sorted_ && facets_[end].key == facets_[end - 1].key) ++end;
  block_.resize(end - next_);
  for (std::size_t k = next_; k < end; ++k) {
    block_[k - next_] = {facets_[k].side, complex_.facet(facets_[k].side)};
  }
  for (std::size_t i = next_, j = next_; i < end; i = j) {
    for (j = i + 1; j < end && facets_[j].key == facets_[i].key;) ++j;
    if (j - i > 1) sort_ties(std::span(block_).subspan(i - next_, j - i));
  }
  next_ = end;
  return block_;
}

void FacetQueue::sort_next_bucket() {
  while (ends_[bucket_] == sorted_) ++bucket_;
  const std::size_t begin = sorted_;
  const std::size_t end = ends_[bucket_];
  other_.resize(end - begin);
  const auto pass = [](const Keyed* from, const Keyed* from_end, Keyed* to, unsigned shift) {
    std::array<std::size_t, kDigits + 1> starts{};
    for (const Keyed* k = from; k != from_end; ++k) ++starts[((k->key >> shift) & (kDigits - 1)) + 1];
    for (std::size_t d = 0; d < kDigits; ++d) starts[d + 1] += starts[d];
    for (const Keyed* k = from; k != from_end; ++k) to[starts[(k->key >> shift) & (kDigits - 1)]++] = *k;
  };
  pass(facets_.data() + begin, facets_.data() + end, other_.data(), 0);
  pass(other_.data(), other_.data() + other_.size(), facets_.data() + begin, kDigitBits);
  sorted_ = end;
}

/// Facets whose rounded λ² is the same: exactly, then by the other edges, then by their vertices. Most ties are the
/// facets at one edge.
void FacetQueue::sort_ties(std::span<ListedFacet> facets) {
  ties_.clear();
  for (const ListedFacet& f : facets) ties_.emplace_back(criterion_.squares(f.vertices), f);
  std::ranges::sort(ties_, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.vertices < b.second.vertices;
  });
  for (std::size_t k = 0; k < facets.size(); ++k) facets[k] = ties_[k].second;
}

}  // namespace surfaced::boundary
