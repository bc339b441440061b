// SPDX-License-Identifier: GPL-3.0-or-later
// Files that people send and that are no clouds, or clouds in formats that are not read.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace surfaced::io {

bool starts_with(std::span<const std::byte> bytes, std::string_view magic);

/// What the file is and what to do with it: "a PNG picture, not points". None if its beginning is of no known kind.
/// @param start  the first kilobytes.
std::optional<std::string> stranger_in(std::span<const std::byte> start);

/// The same for a JSON object that is no glTF.
std::string json_stranger(std::string_view start);

/// What a file of no known kind begins with, as text and in hexadecimal.
std::string shown(std::span<const std::byte> bytes);

}  // namespace surfaced::io
