// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace surfaced {

/// The codes of proto/errors.json, in its order.
enum class ErrorCode : std::uint8_t {
#define SURFACED_ERROR(code, exit_code) code,
#include "base/error_codes.inc"
#undef SURFACED_ERROR
};

/// Name of the code as it stands in proto/errors.json (lower_snake).
std::string_view name_of(ErrorCode code);

/// Exit code of the command for this error: 2 wrong use, 3 input refused, 4 method failed, 5 limit or cancellation.
int exit_code_of(ErrorCode code);

/// The code with this name; false if proto/errors.json has none.
bool error_code_named(std::string_view name, ErrorCode& code);

/// What of `detail` a program wants in pieces, where one named thing is wrong.
struct Fault {
  /// Name of the parameter, header, member of a body or flag.
  std::string field;
  /// As it was given; none if it is missing.
  std::optional<std::string> value;
  /// What would have been taken, in words.
  std::string allowed;
};

/// Why something could not be done. `detail` says what, where, the offending value and the limit;
/// the remedy stands with the code in proto/errors.json.
struct Error {
  ErrorCode code;
  std::string detail;
  /// Shared, because errors are copied. None where no single field is at fault.
  std::shared_ptr<const Fault> fault{};
};

/// The error with its fault.
Error with_fault(Error error, Fault fault);

/// A value, or the error that stood in its way.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

/// Result of an action that has no value.
struct Done {};
using Status = Result<Done>;

}  // namespace surfaced
