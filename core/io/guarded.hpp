// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/base.hpp"

namespace surfaced::io {

/// Runs a reader or writer and turns what it throws into errors: the wall of this room.
template <class T, class Work>
Result<T> guarded(std::string_view name, Work work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, std::string(name) + ": not enough memory to hold it"};
  } catch (const std::length_error& error) {
    return Error{ErrorCode::out_of_memory, std::string(name) + ": larger than any array can be (" + error.what() + ")"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::internal_error, std::string(name) + ": " + error.what()};
  }
}

}  // namespace surfaced::io
