// SPDX-License-Identifier: GPL-3.0-or-later
// The header of a PLY file: what is declared, not yet believed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes.hpp"

namespace surfaced::io {

enum class Scalar : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of a scalar in a binary file.
std::size_t size_of(Scalar type);

/// A scalar property, or a list of them with a count in front.
struct PlyProperty {
  std::string name;
  Scalar type{};
  std::optional<Scalar> count_type;

  bool is_list() const { return count_type.has_value(); }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Index of the property with this name; if there is none, of one that differs in the case of its letters alone.
  std::optional<std::size_t> find(std::string_view property) const;
  /// Least number of bytes of a row in a binary file (all lists empty); exact without lists.
  std::size_t least_binary_row() const;
  /// Least number of bytes of a row in an ascii file: a character and a separator per value; the last
  /// row of a file may lack its separator.
  std::size_t least_ascii_row() const { return 2 * properties.size(); }
};

enum class PlyEncoding : std::uint8_t { ascii, binary_little_endian, binary_big_endian };

struct PlyHeader {
  PlyEncoding encoding{};
  std::vector<PlyElement> elements;

  const PlyElement* find(std::string_view element) const;
};

/// True if the bytes begin as every PLY file does.
bool looks_like_ply(std::span<const std::byte> bytes);

/// Reads the header and leaves the source at the first byte of the data. Lines end with LF, CRLF or,
/// if the first one does, CR. Checks every element's declared count against the bytes at hand.
/// @return  the header; malformed_input, unsupported_feature, truncated_input with line or element.
/// @cost    O(header), at most 1 MiB.
Result<PlyHeader> read_ply_header(ByteSource& source, std::string_view name);

}  // namespace surfaced::io
