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
  error.fault = std::make_shared<const Fault>(std::move(fault));
  return error;
}

}  // namespace surfaced
