// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

/// Error of a failed system call: storage_full when the disk or the quota is full, else
/// internal_error. The detail is "cannot ACTION: REASON"; it goes to clients, so `action` names no path.
Error system_error(std::string_view action, int error_number);

/// What strerror says, safe in threads.
std::string error_text(int error_number);

/// Makes the names in a directory durable.
Status sync_directory(const std::filesystem::path& directory);

/// Creates a directory and its missing parents, for the owner alone, and makes the last one durable.
Status make_directory(const std::filesystem::path& directory);

/// What is in a folder, in no order. What comes or goes meanwhile may be missing or be there.
Result<std::vector<std::filesystem::path>> entries_of(const std::filesystem::path& folder);

/// Opens a regular file for reading; a symbolic link or anything else is refused.
Result<UniqueFd> open_regular(const std::filesystem::path& path);

/// SHA-256 of an open file, read from its beginning.
Result<std::string> digest_of(const UniqueFd& file);

/// Writes all bytes, however often the system call returns early.
Status write_all(int fd, std::span<const std::byte> bytes, std::string_view action);

/// Writes a file under its name at once and durably: what was there stays until all of it is.
Status write_file_durably(const std::filesystem::path& path, std::string_view content);

/// Size of an open file.
Result<std::uint64_t> file_size(int fd);

inline std::span<const std::byte> as_bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

}  // namespace surfaced
