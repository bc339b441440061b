// SPDX-License-Identifier: GPL-3.0-or-later
// A copy of a data folder on which a service can be started as it was at one moment.
//
//   TARGET/store, inputs/, outputs/, partial/   the files that the records refer to, and no others
//   TARGET/jobs.sqlite                          the records; has its name only once everything else is there
//   TARGET/backup.json                          written last: what was copied, with the hash of jobs.sqlite
//
// A backup holds the BackupLease, so nothing that a record of its moment refers to is removed while it copies; files
// never change once a record knows them, and of an unfinished upload the bytes that its record counts do not. Before it
// says that it is done, everything was synced and read again, and has the hash that its record has.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/base.hpp"

namespace surfaced {

/// What a backup has.
struct BackupContents {
  std::uint64_t jobs = 0;
  std::uint64_t clouds = 0;
  /// Unfinished.
  std::uint64_t uploads = 0;
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;
};

/// Makes a backup in a folder that is empty or does not exist yet, while a service may run.
/// @return  invalid_usage; not_ready if another backup is being made; malformed_input if files of the data folder are
/// not
///          what their records say: then TARGET has no jobs.sqlite, and no service starts on it
Result<BackupContents> back_up(const std::filesystem::path& data, const std::filesystem::path& target);

/// Reads all of a backup and compares it with its records.
/// @return  malformed_input with what is wrong
Result<BackupContents> verify_backup(const std::filesystem::path& backup);

/// To be called when a service starts on the folder: it is no backup any more.
Status end_backup(const std::filesystem::path& data);

}  // namespace surfaced
