// SPDX-License-Identifier: GPL-3.0-or-later
// Values taken from bytes, so that any bytes make a case and a fuzzer can change one choice at a time.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

namespace surfaced::testing {

/// The numbers of splitmix64 (Steele, Lea, Flood 2014): the same on every machine.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed) {}

  std::uint64_t word() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(word() % n); }
  /// In [0, 1).
  double unit() { return static_cast<double>(word() >> 11U) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  std::uint64_t state_;
};

/// Zeros once the bytes are used up.
class Choices {
 public:
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (at_ == bytes_.size()) return 0;
    return bytes_[at_++];
  }
  /// n at most 65,536.
  std::size_t below(std::size_t n) {
    const std::size_t low = byte();
    return n <= 256 ? low % n : (low | static_cast<std::size_t>(byte()) << 8U) % n;
  }
  /// True for `of256` of the 256 values of a byte, never for 0.
  bool chance(unsigned of256) { return 256U - byte() <= of256; }
  std::uint64_t word() {
    std::uint64_t value = 0;
    for (unsigned i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(byte()) << (8 * i);
    return value;
  }
  /// Any finite double; 0 for others.
  double real() {
    const std::uint64_t bits = word();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return std::isfinite(value) ? value : 0;
  }
  template <class T, std::size_t N>
  T one_of(const T (&values)[N]) {
    return values[below(N)];
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace surfaced::testing
