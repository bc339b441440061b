// SPDX-License-Identifier: GPL-3.0-or-later
// What was refused in tests, and why.
#pragma once

#include <string>

#include "base/base.hpp"

namespace surfaced::testing {

/// Code of the error, or "ok".
template <class T>
std::string code_of(const Result<T>& result) {
  return result ? "ok" : std::string(name_of(result.error().code));
}

template <class T>
std::string detail_of(const Result<T>& result) {
  return result ? "" : result.error().detail;
}

}  // namespace surfaced::testing
