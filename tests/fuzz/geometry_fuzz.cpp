// SPDX-License-Identifier: GPL-3.0-or-later
// Small clouds and parameters from the bytes, through all methods and the stages around them.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "geometry/geometry_case.hpp"

namespace {

/// In memory where the machine has such a folder: every case writes two files.
std::filesystem::path folder() {
  std::filesystem::path base = "/dev/shm";
  if (!std::filesystem::is_directory(base)) base = std::filesystem::temp_directory_path();
  base /= "surfaced-geometry-fuzz-" + std::to_string(::getpid());
  std::filesystem::create_directories(base);
  return base;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace surfaced::testing;
  constexpr std::size_t kMostPoints = 80;
  static const std::filesystem::path where = folder();
  run_case(geometry_case(std::span(data, size), kMostPoints), where);
  return 0;
}
