// SPDX-License-Identifier: GPL-3.0-or-later
// PLY readers that could stand where ours does.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace surfaced::benchmarks {

/// Each reads the points of a file, and normals and colours where it can.
/// @return  the number of points; none if the file is refused.
std::optional<std::size_t> read_with_surfaced(const std::string& path);
std::optional<std::size_t> read_with_cgal(const std::string& path);
std::optional<std::size_t> read_with_draco(const std::string& path);

}  // namespace surfaced::benchmarks
