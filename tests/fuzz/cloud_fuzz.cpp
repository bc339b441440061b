// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds and meshes of the formats of other programs, one target a format (their seeds differ): read from memory and
// streamed from a file, which must agree.
#include <cstring>

#include "fuzz/fuzz_input.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

/// Equal bit for bit, NaN included.
template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes = as_bytes(data, size);
  const MemoryFile file(bytes);
  const Result<RawCloud> cloud = parse_cloud(bytes, "fuzz");
  const Result<RawCloud> streamed = read_cloud(file.path());
  demand(cloud.ok() == streamed.ok(), "memory and file give the same result");
  if (cloud) {
    check_cloud(*cloud);
    demand(same(cloud->positions, streamed->positions) && same(cloud->normals, streamed->normals) &&
               same(cloud->colors, streamed->colors),
           "memory and file give the same cloud");
  } else {
    check_error(cloud.error());
    demand(cloud.error().code == streamed.error().code, "memory and file are refused with the same code");
  }
  if (const Result<TriangleMesh> mesh = decode_mesh(bytes, "fuzz")) {
    check_mesh(*mesh);
  } else {
    check_error(mesh.error());
  }
  return 0;
}
