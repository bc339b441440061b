// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: numbers in sentences.
#pragma once

#include <iomanip>
#include <sstream>
#include <string>

namespace surfaced {

/// Three digits: what is said of a sample deserves no more.
inline std::string briefly(double length) {
  std::ostringstream text;
  text << std::setprecision(3) << length;
  return text.str();
}

}  // namespace surfaced
