// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "base/sha256.hpp"

namespace surfaced {

/// Fills with random bits from the kernel.
void fill_random(std::span<std::byte> bytes);

/// `Bytes` * 8 random bits as lower-case hexadecimal digits.
template <std::size_t Bytes>
std::string random_hex() {
  std::array<std::byte, Bytes> bytes{};
  fill_random(bytes);
  return to_hex(bytes);
}

}  // namespace surfaced
