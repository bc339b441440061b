// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "base/base.hpp"

namespace surfaced {

/// Asks whether there is space while bytes come in whose number nobody knows: before the first of them, and then once
/// for every 64 KiB. What may be written until the next look is asked for in advance, so that a writer alone never
/// takes what is to stay free, and writers at the same time take 64 KiB each of it at most. Another 64 KiB are asked
/// for besides: the job store writes records of what came, and a file's last block is rounded up.
class SpaceLooks {
 public:
  /// storage_full unless this many bytes may be written.
  using Check = std::function<Status(std::uint64_t needed)>;

  explicit SpaceLooks(Check check) : check_(std::move(check)) {}

  /// To be asked before every write.
  Status before(std::uint64_t bytes) {
    if (bytes <= granted_) {
      granted_ -= bytes;
      return Done{};
    }
    constexpr std::uint64_t kBetweenLooks = std::uint64_t{64} << 10;
    constexpr std::uint64_t kForRecords = std::uint64_t{64} << 10;
    if (Status space = check_(bytes + kBetweenLooks + kForRecords); !space.ok()) return space;
    granted_ = kBetweenLooks;
    return Done{};
  }

 private:
  Check check_;
  std::uint64_t granted_ = 0;
};

}  // namespace surfaced
