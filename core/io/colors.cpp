// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/colors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfaced::io {
namespace {

float full_brightness(float largest, bool fractions) {
  if (fractions && largest <= 1) return 1;
  for (const float full : {255.0F, 65535.0F, static_cast<float>(std::numeric_limits<std::uint32_t>::max())}) {
    if (largest <= full) return full;
  }
  return largest;
}

}  // namespace

std::vector<Color4> to_bytes(const std::vector<WideColor>& colors, bool fractions, bool alpha,
                             std::vector<std::string>& warnings) {
  const std::size_t channels = alpha ? 4 : 3;
  float largest = 0;
  for (const WideColor& color : colors) {
    for (std::size_t c = 0; c < channels; ++c) {
      if (!std::isfinite(color[c])) {
        warnings.push_back("colours dropped: that of point " + std::to_string(&color - colors.data()) +
                           " is not finite");
        return {};
      }
      largest = std::max(largest, color[c]);
    }
  }
  const double scale = 255 / static_cast<double>(full_brightness(largest, fractions));
  std::vector<Color4> bytes(colors.size(), Color4{0, 0, 0, 255});
  for (std::size_t i = 0; i < colors.size(); ++i) {
    for (std::size_t c = 0; c < channels; ++c) {
      bytes[i][c] =
          static_cast<std::uint8_t>(std::clamp(std::round(scale * static_cast<double>(colors[i][c])), 0.0, 255.0));
    }
  }
  return bytes;
}

}  // namespace surfaced::io
