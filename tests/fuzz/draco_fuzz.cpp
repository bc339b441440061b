// SPDX-License-Identifier: GPL-3.0-or-later
// Draco clouds and meshes. Debian's library itself is not instrumented, only malloc, memcpy and what
// its headers bring into our code.
#include "fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace surfaced;
  using namespace surfaced::testing;
  const std::span<const std::byte> bytes = as_bytes(data, size);
  if (const Result<RawCloud> cloud = parse_cloud(bytes, "fuzz")) {
    check_cloud(*cloud);
  } else {
    check_error(cloud.error());
  }
  if (const Result<TriangleMesh> mesh = decode_mesh(bytes, "fuzz")) {
    check_mesh(*mesh);
  } else {
    check_error(mesh.error());
  }
  return 0;
}
