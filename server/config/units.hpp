// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers with units, as people write and read them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace surfaced {

enum class SettingUnit : std::uint8_t { text, path, count, bytes, seconds, bytes_per_second };

/// More than any disk has: beyond, sizes are refused.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 60;

/// Counts: 1000. Durations: 90, 90 s, 15 min, 1.5 h, 1d, 2 w, 1h 30min. Sizes: 4096, 64KiB, 1.5 GB, 2G; K, KB and KiB
/// all are 1024, and a rate may end in /s. Case and spaces do not matter.
/// @return  seconds or bytes; none for anything else, a part of a second, or more than 2^60.
std::optional<std::uint64_t> number_in(SettingUnit unit, std::string_view text);

/// The number in the largest unit that holds it without a remainder: "1 d", "90 s", "256 MiB", "4 KiB/s".
std::string with_unit(SettingUnit unit, std::uint64_t value);

/// What `number_in` takes, for a message: "90 s, 15 min, 1.5 h, 1 d"; empty for counts and texts.
std::string_view examples_of(SettingUnit unit);

}  // namespace surfaced
