// SPDX-License-Identifier: GPL-3.0-or-later
// ZIP archives (PKWARE APPNOTE 6.3) as far as 3MF needs them: deflated files, no encryption, below 4 GiB.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/formats.hpp"

namespace surfaced::io {

struct ZipEntry {
  std::string name;
  std::string text;
};

/// The same entries give the same bytes: no times are written.
/// @return  output_not_writable if an entry or the archive would reach 4 GiB.
Result<Bytes> write_zip(const std::vector<ZipEntry>& entries);

/// A file in an archive, as its directory declares it.
struct ZipMember {
  std::string name;
  std::uint64_t packed = 0;
  std::uint64_t size = 0;
  std::uint64_t offset = 0;
  std::uint16_t method = 0;
  bool encrypted = false;
};

/// Whether bytes begin as an archive.
bool looks_like_zip(std::span<const std::byte> bytes);

/// The files of an archive; not its folders.
Result<std::vector<ZipMember>> zip_directory(std::span<const std::byte> bytes, std::string_view name);

/// A file of the archive; one that is deflated may have `most` bytes, which its declared size is compared with before
/// anything is allocated.
Result<Bytes> unpack_member(std::span<const std::byte> bytes, const ZipMember& member, std::uint64_t most,
                            std::string_view name);

/// The text of the first entry whose name ends so, from the archive's directory. A deflated entry may make 64 times its
/// size and 1 MiB, not more.
Result<std::string> read_zip_entry(std::span<const std::byte> bytes, std::string_view name_end, std::string_view name);

}  // namespace surfaced::io
