// SPDX-License-Identifier: GPL-3.0-or-later
// Colours of other types than bytes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/base.hpp"

namespace surfaced::io {

/// Red, green, blue, opacity as a file has them.
using WideColor = std::array<float, 4>;

/// Colours as bytes. What stands for full brightness is told by the largest value there is: 1 (only
/// where `fractions`: floating point, or integers that were normalised), 255, 65535 or 2^32-1,
/// whichever is the least not below it. Without `alpha` the opacity is 255.
/// @return  as many colours; none, with a sentence in `warnings`, if a value is not finite.
std::vector<Color4> to_bytes(const std::vector<WideColor>& colors, bool fractions, bool alpha,
                             std::vector<std::string>& warnings);

}  // namespace surfaced::io
