// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace surfaced {

/// Why code that throws gave up, in words that help. Our own reasons are runtime errors and stay as they are; a library
/// names an expression and a line of its source, which help nobody: there the points are to blame.
inline std::string reason_of(const std::exception& failure) {
  const std::string text = failure.what();
  const bool own = dynamic_cast<const std::runtime_error*>(&failure) != nullptr && text.find("CGAL") == text.npos;
  if (own) return text;
  return "these points lie too close together, or too nearly on a line or in a plane, for its arithmetic; sample=grid "
         "takes near-repeats out, and other methods may take them";
}

}  // namespace surfaced
