// SPDX-License-Identifier: GPL-3.0-or-later
#include "platform/clock.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <ctime>

namespace surfaced {

SystemTime now() { return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

std::string to_rfc3339(SystemTime time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const std::time_t whole = std::chrono::system_clock::to_time_t(seconds);
  std::tm parts{};
  ::gmtime_r(&whole, &parts);
  std::array<char, 64> text{};
  const auto length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text.data() + length, text.size() - length, ".%03dZ", static_cast<int>((time - seconds).count()));
  return text.data();
}

std::string to_http_date(SystemTime time) {
  const std::time_t whole = std::chrono::system_clock::to_time_t(std::chrono::floor<std::chrono::seconds>(time));
  std::tm parts{};
  ::gmtime_r(&whole, &parts);
  std::array<char, 64> text{};
  // The server never sets a locale, so the names are English.
  std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &parts);
  return text.data();
}

SystemTime from_rfc3339(std::string_view text) {
  const auto part = [&](std::size_t at, std::size_t length) {
    unsigned value = 0;
    if (text.size() >= at + length) std::from_chars(text.data() + at, text.data() + at + length, value);
    return value;
  };
  using namespace std::chrono;
  const auto day = year(static_cast<int>(part(0, 4))) / month(part(5, 2)) / std::chrono::day(part(8, 2));
  return SystemTime(sys_days(day) + hours(part(11, 2)) + minutes(part(14, 2)) + seconds(part(17, 2)) +
                    milliseconds(part(20, 3)));
}

std::optional<SystemTime> parse_rfc3339(std::string_view text) {
  constexpr std::string_view kShape = "dddd-dd-ddTdd:dd:dd";
  const auto fits = [](std::string_view given, std::string_view shape) {
    return given.size() >= shape.size() && std::equal(shape.begin(), shape.end(), given.begin(), [](char s, char c) {
             return s == 'd' ? c >= '0' && c <= '9' : s == 'T' ? c == 'T' || c == 't' : c == s;
           });
  };
  if (!fits(text, kShape)) return std::nullopt;
  const SystemTime time = from_rfc3339(text.substr(0, kShape.size()));
  const auto number = [&](std::size_t at) { return (text[at] - '0') * 10 + text[at + 1] - '0'; };
  const auto day = std::chrono::year(number(0) * 100 + number(2)) / number(5) / number(8);
  if (!day.ok() || number(11) > 23 || number(14) > 59 || number(17) > 59) return std::nullopt;
  std::string_view rest = text.substr(kShape.size());
  std::chrono::milliseconds fraction{};
  if (rest.starts_with('.')) {
    const std::size_t end = std::min(rest.find_first_not_of("0123456789", 1), rest.size());
    if (end == 1) return std::nullopt;
    for (std::size_t i = 1, unit = 100; i < 4; ++i, unit /= 10) {
      if (i < end) fraction += std::chrono::milliseconds(static_cast<std::int64_t>(unit) * (rest[i] - '0'));
    }
    rest.remove_prefix(end);
  }
  if (rest == "Z" || rest == "z") return time + fraction;
  if (rest.size() != 6 || (rest[0] != '+' && rest[0] != '-') || !fits(rest.substr(1), "dd:dd")) return std::nullopt;
  const auto at = text.size() - rest.size();
  if (number(at + 1) > 23 || number(at + 4) > 59) return std::nullopt;
  const std::chrono::minutes offset(number(at + 1) * 60 + number(at + 4));
  return rest[0] == '+' ? time + fraction - offset : time + fraction + offset;
}

}  // namespace surfaced
