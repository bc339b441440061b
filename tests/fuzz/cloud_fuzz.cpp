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

/// How a file is read is part of what is tried: most are read as they are.
ReadOptions options_for(std::span<const std::byte> bytes) {
  ReadOptions options;
  unsigned sum = 0;
  for (const std::byte b : bytes) sum += std::to_integer<unsigned>(b);
  switch (sum % 16) {
    case 0:
      options.table.columns = "x,y,-,z";
      break;
    case 1:
      options.table = {.columns = "b,g,r,z,y,x,nx,ny,nz", .separator = Separator::semicolon, .skip = 1};
      break;
    case 2:
      options.table = {.columns = {}, .separator = Separator::tab, .decimal = Decimal::comma};
      break;
    case 3:
      options.take_truncated = true;
      break;
    case 4:
      options.splats = {.least_opacity = 0.5, .largest_scale = 2};
      break;
    default:
      break;
  }
  return options;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes = as_bytes(data, size);
  const MemoryFile file(bytes);
  const ReadOptions options = options_for(bytes);
  const Result<RawCloud> cloud = parse_cloud(bytes, "fuzz", options);
  const Result<RawCloud> streamed = read_cloud(file.path(), options);
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
