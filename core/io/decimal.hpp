// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as the shortest decimal text that reads back as the same number.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace surfaced::io {

template <class T>
void append_decimal(std::string& text, T value) {
  std::array<char, 32> digits{};
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace surfaced::io
