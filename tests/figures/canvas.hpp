// SPDX-License-Identifier: GPL-3.0-or-later
// A software rasteriser of its own for the figures of the documentation: no graphics card, no window, no library but
// zlib.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <vector>

namespace surfaced::figures {

/// Red, green, blue; 0..1.
using Colour = std::array<double, 3>;

/// x to the right and y downwards in pixels, z towards the viewer.
struct ScreenPoint {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// A square picture with a depth buffer, drawn at kSamples times its size and averaged down when it is written.
class Canvas {
 public:
  explicit Canvas(std::size_t size);

  void triangle(const std::array<ScreenPoint, 3>& corners, const Colour& colour);
  /// @param width  in pixels of the picture.
  /// @param lift   how far in front of what it lies on, in pixels.
  void line(const ScreenPoint& from, const ScreenPoint& to, double width, double lift, const Colour& colour);
  /// A disc that faces the viewer.
  void dot(const ScreenPoint& centre, double radius, const Colour& colour);

  /// PNG, 8-bit RGB, the best of zlib's compression.
  bool write_png(const std::filesystem::path& path) const;

 private:
  static constexpr std::size_t kSamples = 3;
  void put(std::size_t x, std::size_t y, double z, const Colour& colour);
  /// The samples that an extent in pixels covers, cut to the picture: first and one past the last.
  std::array<std::size_t, 2> covered(double low, double high) const;
  std::vector<std::uint8_t> rows() const;

  std::size_t size_;
  std::size_t side_;
  std::vector<double> depth_;
  std::vector<Colour> colours_;
};

}  // namespace surfaced::figures
