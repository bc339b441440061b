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

/// The text of the first entry whose name ends so, from the archive's directory. A deflated entry may make `most_ratio`
/// times its size and 1 MiB, not more.
Result<std::string> read_zip_entry(std::span<const std::byte> bytes, std::string_view name_end, std::string_view name);

}  // namespace surfaced::io
