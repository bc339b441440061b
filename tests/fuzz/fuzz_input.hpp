// SPDX-License-Identifier: GPL-3.0-or-later
// What the fuzz targets share.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <span>
#include <string>

#include "io/io.hpp"

namespace surfaced::testing {

inline std::span<const std::byte> as_bytes(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const std::byte*>(data), size};
}

/// Ends the run with a message: libFuzzer keeps the input.
inline void demand(bool holds, const char* claim) {
  if (holds) return;
  std::cerr << "does not hold: " << claim << '\n';
  std::abort();
}

/// A file in memory, gone with the object.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::byte> bytes) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    demand(descriptor_ >= 0 && ::write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
           "a file in memory can be written");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

/// What must hold of every cloud that a reader returns.
inline void check_cloud(const RawCloud& cloud) {
  demand(cloud.size() > 0, "a cloud that was read has a point");
  demand(cloud.normals.empty() || cloud.normals.size() == cloud.size(), "every point has a normal or none has");
  demand(cloud.colors.empty() || cloud.colors.size() == cloud.size(), "every point has a colour or none has");
}

/// What must hold of every mesh that a reader returns.
inline void check_mesh(const TriangleMesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  demand(vertices > 0, "a mesh that was read has a vertex");
  demand(mesh.normals.empty() || mesh.normals.size() == vertices, "every vertex has a normal or none has");
  demand(mesh.colors.empty() || mesh.colors.size() == vertices, "every vertex has a colour or none has");
  for (const Triangle& t : mesh.triangles) {
    demand(t[0] < vertices && t[1] < vertices && t[2] < vertices, "every corner is a vertex");
    demand(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "the corners of a triangle differ");
  }
}

/// Every refusal says what and where.
inline void check_error(const Error& error) {
  demand(!error.detail.empty() && error.detail.size() < 4096, "a refusal has a message of sensible length");
  demand(error.code != ErrorCode::internal_error, "a file never causes an internal error");
}

}  // namespace surfaced::testing
