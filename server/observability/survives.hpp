// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>
#include <string_view>

namespace surfaced {

/// Logs what an exception says; never throws.
void log_failure(std::string_view doing, const std::exception& failure) noexcept;

/// Does one piece of work of a thread that has to go on whatever happens: an exception (memory has run out, a record
/// cannot be read) is logged and costs this piece alone, where it would end the server if it left the thread.
/// @return  whether the work came to its end
template <class Work>
bool survives(std::string_view doing, const Work& work) noexcept {
  try {
    work();
    return true;
  } catch (const std::exception& failure) {
    log_failure(doing, failure);
  }
  return false;
}

}  // namespace surfaced
