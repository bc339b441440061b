// SPDX-License-Identifier: GPL-3.0-or-later
// A cloud and a job made of any bytes, and what must hold of what comes of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "cloud/cloud.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::testing {

struct GeometryCase {
  RawCloud cloud;
  const MethodInfo* method = nullptr;
  /// As check_parameters returns them; those that differ from the defaults were chosen.
  Json parameters;
  /// Of the mesh's file, with its dot.
  std::string extension;

  /// One line that tells the case.
  std::string text() const;
};

/// @param most_points  the cloud has no more, and at least one.
GeometryCase geometry_case(std::span<const std::uint8_t> bytes, std::size_t most_points);

/// The same of a number; cases of consecutive numbers have nothing in common.
GeometryCase geometry_case(std::uint64_t number, std::size_t most_points);

/// Writes the cloud into the folder, and takes it the whole way to a mesh and its report, which are checked.
/// Where a claim does not hold, it is printed and the process aborts.
/// @return  the name of the error, or "done".
std::string run_case(const GeometryCase& geometry, const std::filesystem::path& folder);

}  // namespace surfaced::testing
