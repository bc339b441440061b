// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of a binary STL, and where the coordinates of one of ours begin: float32 cannot hold georeferenced ones,
// and the header has room for text.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

#include "base/base.hpp"

namespace surfaced::io {

/// Bytes of a binary STL's header, before the count of facets, and of each facet.
inline constexpr std::size_t kStlHeader = 80;
inline constexpr std::size_t kStlFacet = 50;

inline constexpr std::string_view kStlOrigin = "surfaced, origin ";

/// The text for the header; longer than 80 bytes if the numbers need more than it holds.
inline std::string stl_origin_text(const Point3& origin) {
  std::string text(kStlOrigin);
  for (const double x : origin) {
    std::array<char, 32> digits{};
    text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr);
    text += ' ';
  }
  return text;
}

/// What stl_origin_text wrote; zero for any other header.
inline Point3 stl_origin_in(std::string_view header) {
  if (!header.starts_with(kStlOrigin)) return {};
  const char* at = header.data() + kStlOrigin.size();
  const char* const end = header.data() + header.size();
  Point3 origin{};
  for (double& x : origin) {
    const auto [stop, problem] = std::from_chars(at, end, x);
    if (problem != std::errc{} || stop == end) return {};
    at = stop + 1;
  }
  return origin;
}

}  // namespace surfaced::io
