#include "minimum_boundary/facet_queue.hpp"

#include <algorithm>
#include <array>
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

}  // namespace

FacetQueue::FacetQueue(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads)
    : complex_(complex), criterion_(criterion), ends_(kBuckets, 0) {
  std::vector<Keyed> keyed;
  keyed.reserve(2 * complex.cells());
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    const unsigned first = complex.infinite(CellIndex(c)) ? 3 : 0;
    for (std::size_t s = 4 * c + first; s < 4 * c + 4; ++s) {
      if (s < complex.mate(s)) keyed.push_back({0, SideIndex(s)});
    }
  }
  // Rounding to float is monotone, and the bits of non-negative floats ascend with their values.
  parallel_ranges(threads, keyed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      keyed[k].key = std::bit_cast<std::uint32_t>(static_cast<float>(criterion.squared(keyed[k].side)));
    }
  });
  std::vector<std::size_t> starts(kBuckets + 1, 0);
  for (const Keyed& k : keyed) ++starts[(k.key >> kBucketShift) + 1];
  for (std::size_t b = 0; b < kBuckets; ++b) starts[b + 1] += starts[b];
  facets_.resize(keyed.size());
  for (const Keyed& k : keyed) facets_[starts[k.key >> kBucketShift]++] = k;
  std::copy(starts.begin(), starts.end() - 1, ends_.begin());
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
  for (std::size_t i = begin, j = begin; i < end; i = j) {
    for (j = i + 1; j < end && facets_[j].key == facets_[i].key;) ++j;
    if (j - i > 1) sort_ties(i, j);
  }
  sorted_ = end;
}

/// Facets whose rounded λ² is the same: exactly, then by their vertices.
void FacetQueue::sort_ties(std::size_t begin, std::size_t end) {
  struct Exact {
    double squared;
    std::array<VertexIndex, 3> facet;
    SideIndex side;
  };
  static thread_local std::vector<Exact> exact;
  exact.clear();
  for (std::size_t k = begin; k < end; ++k) {
    exact.push_back({criterion_.squared(facets_[k].side), complex_.facet(facets_[k].side), facets_[k].side});
  }
  std::ranges::sort(exact, [](const Exact& a, const Exact& b) {
    return a.squared != b.squared ? a.squared < b.squared : a.facet < b.facet;
  });
  for (std::size_t k = begin; k < end; ++k) facets_[k].side = exact[k - begin].side;
}

}  // namespace surfaced::boundary
