// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/units.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <span>

#include "base/text.hpp"

namespace surfaced {
namespace {

struct Suffix {
  std::string_view name;
  std::uint64_t factor;
};

constexpr std::uint64_t kMinute = 60;
constexpr std::uint64_t kHour = 60 * kMinute;
constexpr std::uint64_t kDay = 24 * kHour;
constexpr auto kDurations = std::to_array<Suffix>(
    {{"", 1}, {"s", 1}, {"sec", 1}, {"m", kMinute}, {"min", kMinute}, {"h", kHour}, {"d", kDay}, {"w", 7 * kDay}});
constexpr std::uint64_t kKibi = 1024;
constexpr auto kSizes = std::to_array<Suffix>({{"", 1},
                                               {"b", 1},
                                               {"k", kKibi},
                                               {"kb", kKibi},
                                               {"kib", kKibi},
                                               {"m", kKibi << 10U},
                                               {"mb", kKibi << 10U},
                                               {"mib", kKibi << 10U},
                                               {"g", kKibi << 20U},
                                               {"gb", kKibi << 20U},
                                               {"gib", kKibi << 20U},
                                               {"t", kKibi << 30U},
                                               {"tb", kKibi << 30U},
                                               {"tib", kKibi << 30U}});

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A number of the text's beginning, with its fraction in units of 1/scale. Takes it off the text.
struct Decimal {
  std::uint64_t whole = 0;
  std::uint64_t fraction = 0;
  std::uint64_t scale = 1;
};

std::optional<Decimal> take_decimal(std::string_view& text) {
  constexpr std::uint64_t kFinest = 1'000'000;
  Decimal number;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number.whole);
  if (failed != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.starts_with('.')) return number;
  text.remove_prefix(1);
  if (text.empty() || !is_digit(text.front())) return std::nullopt;
  for (; !text.empty() && is_digit(text.front()); text.remove_prefix(1)) {
    if (number.scale == kFinest) return std::nullopt;
    number.scale *= 10;
    number.fraction = number.fraction * 10 + static_cast<std::uint64_t>(text.front() - '0');
  }
  return number;
}

/// The number times the factor; none beyond 2^60, or where a remainder would be lost and must not be.
std::optional<std::uint64_t> product(const Decimal& number, std::uint64_t factor, bool exact) {
  if (number.whole > kMostBytes / factor) return std::nullopt;
  const std::uint64_t part = number.fraction * factor;  // below 2^20 times 2^40
  if (exact && part % number.scale != 0) return std::nullopt;
  return number.whole * factor + part / number.scale;
}

std::optional<std::uint64_t> sum_of_terms(std::string_view text, std::span<const Suffix> suffixes, bool exact,
                                          bool several) {
  std::uint64_t sum = 0;
  bool first = true;
  while (!text.empty()) {
    if (!first && !several) return std::nullopt;
    const auto number = take_decimal(text);
    if (!number) return std::nullopt;
    std::size_t length = 0;
    while (length < text.size() && !is_digit(text[length]) && text[length] != '.') ++length;
    const auto suffix = std::ranges::find(suffixes, text.substr(0, length), &Suffix::name);
    if (suffix == suffixes.end() || (suffix->name.empty() && !first)) return std::nullopt;
    const auto term = product(*number, suffix->factor, exact);
    if (!term || *term > kMostBytes - sum) return std::nullopt;
    sum += *term;
    text.remove_prefix(length);
    first = false;
  }
  return first ? std::nullopt : std::optional(sum);
}

struct Shown {
  std::string_view name;
  std::uint64_t factor;
};

std::string in_largest(std::span<const Shown> units, std::uint64_t value) {
  const auto fits = [value](const Shown& each) { return value >= each.factor && value % each.factor == 0; };
  const auto largest = std::ranges::find_if(units, fits);
  const Shown& unit = largest == units.end() ? units.back() : *largest;
  return std::to_string(value / unit.factor) + " " + std::string(unit.name);
}

}  // namespace

std::optional<std::uint64_t> number_in(SettingUnit unit, std::string_view text) {
  std::string plain = in_lower_case(text);
  std::erase(plain, ' ');
  if (unit == SettingUnit::seconds) return sum_of_terms(plain, kDurations, true, true);
  if (unit == SettingUnit::bytes || unit == SettingUnit::bytes_per_second) {
    if (unit == SettingUnit::bytes_per_second && plain.ends_with("/s")) plain.resize(plain.size() - 2);
    return sum_of_terms(plain, kSizes, false, false);
  }
  return sum_of_terms(plain, std::span(kDurations).first(1), true, false);
}

std::string with_unit(SettingUnit unit, std::uint64_t value) {
  constexpr auto kTimes = std::to_array<Shown>({{"d", kDay}, {"h", kHour}, {"min", kMinute}, {"s", 1}});
  constexpr auto kBytes = std::to_array<Shown>(
      {{"TiB", kKibi << 30U}, {"GiB", kKibi << 20U}, {"MiB", kKibi << 10U}, {"KiB", kKibi}, {"B", 1}});
  if (unit == SettingUnit::seconds) return in_largest(kTimes, value);
  if (unit == SettingUnit::bytes) return in_largest(kBytes, value);
  if (unit == SettingUnit::bytes_per_second) return in_largest(kBytes, value) + "/s";
  return std::to_string(value);
}

std::string_view examples_of(SettingUnit unit) {
  if (unit == SettingUnit::seconds) return "90 s, 15 min, 1.5 h, 1 d";
  if (unit == SettingUnit::bytes) return "4096, 512 MiB, 1.5 GB";
  if (unit == SettingUnit::bytes_per_second) return "4096, 64 KiB/s, 1.5 MB/s";
  return {};
}

}  // namespace surfaced
