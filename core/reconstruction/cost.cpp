// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/methods.hpp"

namespace surfaced {

Cost most_cost(const MethodInfo& method, std::size_t points) {
  // What a cloud of one point takes: the process, the file, the report.
  constexpr double kStart = 0.01;
  constexpr double kTimes = 1000;
  constexpr std::uint64_t kBytesAlways = std::uint64_t{512} << 20;
  constexpr std::uint64_t kTimesBytes = 100;
  const Cost& each = method_of(method).of_a_point;
  return {.seconds = kTimes * (kStart + each.seconds * static_cast<double>(points)),
          .bytes = kBytesAlways + kTimesBytes * each.bytes * points};
}

}  // namespace surfaced
