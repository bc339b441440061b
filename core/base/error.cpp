// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.hpp"

#include <algorithm>
#include <array>

namespace surfaced {
namespace {

struct Row {
  std::string_view name;
  int exit_code;
};

constexpr auto kRows = std::to_array<Row>({
#define SURFACED_ERROR(code, exit_code) {#code, exit_code},
#include "base/error_codes.inc"
#undef SURFACED_ERROR
});

const Row& row(ErrorCode code) { return kRows.at(static_cast<std::size_t>(code)); }

/// What was given may be as long as a body may be; whoever gave it knows the rest.
constexpr std::size_t kLongestEcho = 1000;

/// Cuts a text that came from outside, between two characters of UTF-8, and the same where the detail quotes it.
void shorten(std::string& echoed, std::string& detail) {
  if (echoed.size() <= kLongestEcho) return;
  const auto goes_on = [&](std::size_t at) { return (static_cast<unsigned char>(echoed[at]) & 0xC0U) == 0x80U; };
  std::size_t end = kLongestEcho;
  // A character has four bytes at most; bytes that are no UTF-8 are cut where the limit is.
  while (end > kLongestEcho - 3 && goes_on(end)) --end;
  std::string cut = echoed.substr(0, end) + "...";
  if (const std::size_t at = detail.find(echoed); at != detail.npos) detail.replace(at, echoed.size(), cut);
  echoed = std::move(cut);
}

}  // namespace

std::string_view name_of(ErrorCode code) { return row(code).name; }

int exit_code_of(ErrorCode code) { return row(code).exit_code; }

bool error_code_named(std::string_view name, ErrorCode& code) {
  const auto* found = std::ranges::find(kRows, name, &Row::name);
  if (found == kRows.end()) return false;
  code = static_cast<ErrorCode>(found - kRows.begin());
  return true;
}

Error with_fault(Error error, Fault fault) {
  shorten(fault.field, error.detail);
  if (fault.value) shorten(*fault.value, error.detail);
  error.fault = std::make_shared<const Fault>(std::move(fault));
  return error;
}

}  // namespace surfaced
