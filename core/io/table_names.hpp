// SPDX-License-Identifier: GPL-3.0-or-later
// What the names in the header of a table mean.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace surfaced::io {

/// What a column of a table is to a cloud.
enum class Role : std::uint8_t { x, y, z, nx, ny, nz, r, g, b, none };
constexpr std::size_t kRoles = static_cast<std::size_t>(Role::none);

/// x, y, z, nx, ny, nz, r, g, b, or - for none.
std::string_view name_of(Role role);

/// Roles from `x,y,z,-,r,g,b`; none if a name is unknown, stands there twice, or x, y or z is missing.
std::optional<std::vector<Role>> roles_named(std::string_view list);

/// What a header says.
struct HeaderMeaning {
  /// Of every column; x, y and z are all there, or none of them.
  std::vector<Role> roles;
  bool has_position = false;
  /// Longitude and latitude instead of lengths.
  bool degrees = false;
  /// Whether x, y or z is called something else (easting, height).
  bool synonyms = false;
};

/// @param cells  without quotes and blanks around them.
HeaderMeaning meaning_of(const std::vector<std::string_view>& cells);

/// The line without units in brackets: `X[m]`, `Y (m)`; an index such as `[0]` stays.
std::string without_units(std::string_view line);

}  // namespace surfaced::io
