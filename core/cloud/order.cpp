// SPDX-License-Identifier: GPL-3.0-or-later
#include "cloud/order.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/sort/spreadsort/integer_sort.hpp>
#include <cmath>

#include "base/parallel.hpp"

namespace surfaced {
namespace {

constexpr int kMortonBits = 21;

std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// Morton key on the bounding cube. Scaling by a power of two is exact, so a cloud scaled by one
/// keeps its order.
class MortonGrid {
 public:
  explicit MortonGrid(const Bounds& bounds) : low_(bounds.low) {
    double side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, bounds.high[axis] - bounds.low[axis]);
    int exponent = 0;
    std::frexp(side, &exponent);  // side < 2^exponent
    const int shift = kMortonBits - exponent;
    // Two factors, for one may be beyond a double's range.
    first_factor_ = std::ldexp(1.0, shift / 2);
    second_factor_ = std::ldexp(1.0, shift - shift / 2);
  }

  std::uint64_t key(const Point3& p) const {
    std::uint64_t key = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cell = (p[axis] - low_[axis]) * first_factor_ * second_factor_;
      const auto clamped = static_cast<std::uint64_t>(std::min(cell, static_cast<double>((1 << kMortonBits) - 1)));
      key |= spread_bits(clamped) << axis;
    }
    return key;
  }

 private:
  Point3 low_;
  double first_factor_ = 1;
  double second_factor_ = 1;
};

std::vector<Entry> unordered(const RawCloud& raw, unsigned threads) {
  const MortonGrid grid(bounds_of(raw.positions));
  std::vector<Entry> entries(raw.size());
  parallel_ranges(threads, raw.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) entries[i] = {grid.key(raw.positions[i]), static_cast<std::uint32_t>(i)};
  });
  return entries;
}

/// Deals the entries into buckets by the leading bits of their keys. Bucket b is entries[starts[b]] up to
/// entries[starts[b+1]].
class Buckets {
 public:
  Buckets(std::vector<Entry>& entries, unsigned threads) : entries_(entries), threads_(threads) {
    std::uint64_t bits = 0;
    for (const Entry& e : entries) bits |= e.key;
    shift_ = std::max(0, static_cast<int>(std::bit_width(bits)) - kBits);
    std::vector<Counts> counts(kPieces);
    each_piece([&](std::size_t piece, const Entry& e) { ++counts[piece][bucket_of(e)]; });
    std::uint32_t at = 0;
    for (std::size_t b = 0; b < kBuckets; ++b) {
      starts_[b] = at;
      for (Counts& piece : counts) at += std::exchange(piece[b], at);
    }
    starts_[kBuckets] = at;
    std::vector<Entry> dealt(entries.size());
    each_piece([&](std::size_t piece, const Entry& e) { dealt[counts[piece][bucket_of(e)]++] = e; });
    entries.swap(dealt);
  }

  /// Calls body(first, last) for every bucket, several at a time.
  template <class Body>
  void each(Body&& body) {
    parallel_tasks(threads_, kBuckets,
                   [&](std::size_t b) { body(entries_.data() + starts_[b], entries_.data() + starts_[b + 1]); });
  }

 private:
  static constexpr int kBits = 12;
  static constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  static constexpr std::size_t kPieces = 16;
  using Counts = std::array<std::uint32_t, kBuckets>;

  std::size_t bucket_of(const Entry& e) const { return e.key >> shift_; }

  template <class Body>
  void each_piece(Body&& body) {
    parallel_tasks(threads_, kPieces, [&](std::size_t piece) {
      const std::size_t end = entries_.size() * (piece + 1) / kPieces;
      for (std::size_t i = entries_.size() * piece / kPieces; i < end; ++i) body(piece, entries_[i]);
    });
  }

  std::vector<Entry>& entries_;
  unsigned threads_;
  int shift_ = 0;
  std::array<std::uint32_t, kBuckets + 1> starts_{};
};

void sort_by_key(Entry* first, Entry* last) {
  boost::sort::spreadsort::integer_sort(
      first, last, [](const Entry& e, unsigned shift) { return e.key >> shift; },
      [](const Entry& a, const Entry& b) { return a.key < b.key; });
}

}  // namespace

std::vector<Entry> canonical_order(const RawCloud& raw, unsigned threads) {
  const auto before = [&](const Entry& a, const Entry& b) {
    if (raw.positions[a.input] != raw.positions[b.input]) return raw.positions[a.input] < raw.positions[b.input];
    if (!raw.normals.empty() && raw.normals[a.input] != raw.normals[b.input])
      return raw.normals[a.input] < raw.normals[b.input];
    if (!raw.colors.empty() && raw.colors[a.input] != raw.colors[b.input])
      return raw.colors[a.input] < raw.colors[b.input];
    return a.input < b.input;
  };
  std::vector<Entry> entries = unordered(raw, threads);
  Buckets(entries, threads).each([&](Entry* first, Entry* last) {
    sort_by_key(first, last);
    for (Entry* run = first; run != last;) {
      Entry* const end = std::find_if(run, last, [run](const Entry& e) { return e.key != run->key; });
      if (end - run > 1) std::sort(run, end, before);
      run = end;
    }
  });
  return entries;
}

}  // namespace surfaced
