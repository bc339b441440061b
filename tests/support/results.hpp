// Results in tests: what was refused, and why.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <string_view>

#include "base/base.hpp"
#include "io/io.hpp"

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

inline std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

inline Result<RawCloud> parse_text(std::string_view text, const ReadLimits& limits = {}) {
  return parse_cloud(as_bytes(text), "test.ply", limits);
}

}  // namespace surfaced::testing
