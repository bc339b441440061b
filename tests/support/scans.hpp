// SPDX-License-Identifier: GPL-3.0-or-later
// The clouds that ./dev data fetches, which need not be there.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "io/io.hpp"

namespace surfaced::testing {

/// The cloud NAME.ply, or none if it is absent.
inline std::optional<PointCloud> scan(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(SURFACED_SHARED_DATA) / (name + ".ply");
  if (!std::filesystem::exists(path)) return std::nullopt;
  return *make_cloud(*read_cloud(path));
}

}  // namespace surfaced::testing
