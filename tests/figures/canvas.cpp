// SPDX-License-Identifier: GPL-3.0-or-later
#include "figures/canvas.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

namespace surfaced::figures {
namespace {

constexpr Colour kPaper{1, 1, 1};

/// Twice the signed area of a, b, p.
double side_of(const ScreenPoint& a, const ScreenPoint& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

void append_number(std::string& bytes, std::uint32_t number) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) bytes += static_cast<char>(number >> shift & 0xFFU);
}

void append_part(std::string& png, const std::string& kind, const std::string& body) {
  append_number(png, static_cast<std::uint32_t>(body.size()));
  const std::string checked = kind + body;
  png += checked;
  const auto* const bytes = reinterpret_cast<const Bytef*>(checked.data());
  append_number(png, static_cast<std::uint32_t>(::crc32(0, bytes, static_cast<uInt>(checked.size()))));
}

}  // namespace

Canvas::Canvas(std::size_t size)
    : size_(size),
      side_(size * kSamples),
      depth_(side_ * side_, -std::numeric_limits<double>::infinity()),
      colours_(side_ * side_, kPaper) {}

void Canvas::put(std::size_t x, std::size_t y, double z, const Colour& colour) {
  const std::size_t at = y * side_ + x;
  if (z <= depth_[at]) return;
  depth_[at] = z;
  colours_[at] = colour;
}

std::array<std::size_t, 2> Canvas::covered(double low, double high) const {
  const double samples = static_cast<double>(kSamples);
  const double last = static_cast<double>(side_);
  return {static_cast<std::size_t>(std::clamp(std::floor(low * samples), 0.0, last)),
          static_cast<std::size_t>(std::clamp(std::ceil(high * samples) + 1, 0.0, last))};
}

void Canvas::triangle(const std::array<ScreenPoint, 3>& corners, const Colour& colour) {
  const auto& [a, b, c] = corners;
  const double area = side_of(a, b, c.x, c.y);
  if (area == 0) return;
  const auto [left, right] = covered(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
  const auto [top, bottom] = covered(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
  for (std::size_t row = top; row < bottom; ++row) {
    for (std::size_t column = left; column < right; ++column) {
      const double x = (static_cast<double>(column) + 0.5) / kSamples;
      const double y = (static_cast<double>(row) + 0.5) / kSamples;
      const double u = side_of(b, c, x, y) / area;
      const double v = side_of(c, a, x, y) / area;
      const double w = 1 - u - v;
      if (u >= 0 && v >= 0 && w >= 0) put(column, row, u * a.z + v * b.z + w * c.z, colour);
    }
  }
}

void Canvas::line(const ScreenPoint& from, const ScreenPoint& to, double width, double lift, const Colour& colour) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double square = dx * dx + dy * dy;
  const double reach = width / 2;
  const auto [left, right] = covered(std::min(from.x, to.x) - reach, std::max(from.x, to.x) + reach);
  const auto [top, bottom] = covered(std::min(from.y, to.y) - reach, std::max(from.y, to.y) + reach);
  for (std::size_t row = top; row < bottom; ++row) {
    for (std::size_t column = left; column < right; ++column) {
      const double x = (static_cast<double>(column) + 0.5) / kSamples - from.x;
      const double y = (static_cast<double>(row) + 0.5) / kSamples - from.y;
      const double along = square > 0 ? std::clamp((x * dx + y * dy) / square, 0.0, 1.0) : 0;
      if (std::hypot(x - along * dx, y - along * dy) > reach) continue;
      put(column, row, from.z + along * (to.z - from.z) + lift, colour);
    }
  }
}

void Canvas::dot(const ScreenPoint& centre, double radius, const Colour& colour) {
  line(centre, centre, 2 * radius, 0, colour);
}

std::vector<std::uint8_t> Canvas::rows() const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(size_ * (3 * size_ + 1));
  for (std::size_t y = 0; y < size_; ++y) {
    bytes.push_back(0);  // no filter
    for (std::size_t x = 0; x < size_; ++x) {
      Colour sum{};
      for (std::size_t sample = 0; sample < kSamples * kSamples; ++sample) {
        const std::size_t at = (y * kSamples + sample / kSamples) * side_ + x * kSamples + sample % kSamples;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += colours_[at][k];
      }
      for (const double part : sum) {
        const double mean = part / static_cast<double>(kSamples * kSamples);
        bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(mean, 0.0, 1.0))));
      }
    }
  }
  return bytes;
}

bool Canvas::write_png(const std::filesystem::path& path) const {
  const std::vector<std::uint8_t> raw = rows();
  uLongf length = ::compressBound(static_cast<uLong>(raw.size()));
  std::string packed(length, '\0');
  if (::compress2(reinterpret_cast<Bytef*>(packed.data()), &length, raw.data(), static_cast<uLong>(raw.size()),
                  Z_BEST_COMPRESSION) != Z_OK) {
    return false;
  }
  packed.resize(length);
  std::string header;
  append_number(header, static_cast<std::uint32_t>(size_));
  append_number(header, static_cast<std::uint32_t>(size_));
  header += std::string{8, 2, 0, 0, 0};  // bits, RGB, and the only ways to compress, filter, and interlace not
  std::string png = "\x89PNG\r\n\x1a\n";
  append_part(png, "IHDR", header);
  append_part(png, "IDAT", packed);
  append_part(png, "IEND", "");
  std::ofstream file(path, std::ios::binary);
  return bool(file << png);
}

}  // namespace surfaced::figures
