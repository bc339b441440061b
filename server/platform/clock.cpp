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

}  // namespace surfaced
