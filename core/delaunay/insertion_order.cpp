// SPDX-License-Identifier: GPL-3.0-or-later
#include "delaunay/insertion_order.hpp"

namespace surfaced {
namespace {

/// One point in 8 goes to an earlier round, one in 64 to the one before, ...
constexpr std::uint64_t kRoundRatio = 8;
constexpr std::size_t kSmallestRound = 64;

/// A fixed scrambling of the index (splitmix64), so that rounds are random but the same in every run.
std::uint64_t scramble(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace

std::vector<std::uint32_t> insertion_order(std::size_t count) {
  unsigned rounds = 1;
  for (std::size_t n = count; n > kSmallestRound; n /= kRoundRatio) ++rounds;
  std::vector<std::uint8_t> round_of(count);
  std::vector<std::size_t> starts(rounds + 1, 0);
  for (std::size_t v = 0; v < count; ++v) {
    std::uint64_t bits = scramble(v);
    unsigned round = rounds - 1;
    while (round > 0 && bits % kRoundRatio == 0) {
      --round;
      bits /= kRoundRatio;
    }
    round_of[v] = static_cast<std::uint8_t>(round);
    ++starts[round + 1];
  }
  for (unsigned r = 0; r < rounds; ++r) starts[r + 1] += starts[r];
  std::vector<std::uint32_t> order(count);
  std::vector<std::size_t> low(starts.begin(), starts.end() - 1);
  std::vector<std::size_t> high(starts.begin() + 1, starts.end());
  for (std::size_t v = 0; v < count; ++v) {
    const unsigned r = round_of[v];
    order[r % 2 == 0 ? low[r]++ : --high[r]] = static_cast<std::uint32_t>(v);
  }
  return order;
}

}  // namespace surfaced
