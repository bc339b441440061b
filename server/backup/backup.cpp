// SPDX-License-Identifier: GPL-3.0-or-later
#include "backup/backup.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "artifacts/backup_lease.hpp"
#include "backup/records.hpp"
#include "base/sha256.hpp"
#include "platform/clock.hpp"
#include "platform/files.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kRecords = "jobs.sqlite";
constexpr const char* kUnfinishedRecords = "jobs.sqlite.unfinished";
constexpr const char* kManifest = "backup.json";
constexpr const char* kIdentity = "store";
/// Beyond, what is wrong is counted and not named.
constexpr std::size_t kMostNamed = 20;
constexpr std::size_t kPiece = std::size_t{1} << 20;

/// What is wrong with a data folder or a copy of it.
class Damage {
 public:
  void add(std::string what) {
    if (++count_ <= kMostNamed) text_ += (text_.empty() ? "" : "; ") + what;
  }
  Status status(const fs::path& folder) const {
    if (count_ == 0) return Done{};
    const std::string more = count_ > kMostNamed ? "; and " + std::to_string(count_ - kMostNamed) + " more" : "";
    return Error{ErrorCode::malformed_input, "'" + folder.string() + "': " + text_ + more};
  }

 private:
  std::size_t count_ = 0;
  std::string text_;
};

/// Calls the function with the first bytes of an open file, in pieces; false if it has fewer.
template <class Sink>
Result<bool> read_first(int fd, std::uint64_t bytes, const Sink& sink) {
  std::vector<std::byte> buffer(kPiece);
  for (std::uint64_t at = 0; at < bytes;) {
    const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), bytes - at));
    const ssize_t count = ::pread(fd, buffer.data(), most, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error("read a file of the service", errno);
    if (count == 0) return false;
    if (Status taken = sink(std::span(buffer).first(static_cast<std::size_t>(count))); !taken.ok())
      return taken.error();
    at += static_cast<std::uint64_t>(count);
  }
  return true;
}

Status make_folder(const fs::path& folder) {
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return Done{};
  return system_error("create the folder " + folder.string(), errno);
}

/// Copies the bytes that the record counts; what is not there is damage, found when the copy is read.
Status copy_file(const fs::path& from, const fs::path& to, std::uint64_t bytes) {
  if (Status made = make_folder(to.parent_path()); !made.ok()) return made;
  std::error_code error;
  if (!fs::exists(from, error)) return Done{};
  const auto source = open_regular(from);
  if (!source) return source.error();
  const UniqueFd target(::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!target) return system_error("write " + to.string(), errno);
  const auto copied = read_first(source->get(), bytes, [&](std::span<const std::byte> piece) {
    return write_all(target.get(), piece, "write " + to.string());
  });
  if (!copied) return copied.error();
  if (::fsync(target.get()) != 0) return system_error("make " + to.string() + " durable", errno);
  // Best effort: what is read again for its hash is to come from the disk.
  ::posix_fadvise(target.get(), 0, 0, POSIX_FADV_DONTNEED);
  return Done{};
}

/// Makes durable which files are in a folder, and in every folder below.
Status sync_folders(const fs::path& folder) {
  const auto entries = entries_of(folder);
  if (!entries) return entries.error();
  for (const fs::path& entry : *entries) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(entry, error);
    if (error) return system_error("look at " + entry.string(), error.value());
    if (status.type() != fs::file_type::directory) continue;
    if (Status synced = sync_folders(entry); !synced.ok()) return synced;
  }
  return sync_directory(folder);
}

/// The hash of a file of exactly this size; empty, and damage, for any other.
Result<std::string> hash_of(const fs::path& folder, const RecordedFile& file, Damage& damage) {
  const auto fd = open_regular(folder / file.path);
  if (!fd) {
    damage.add(file.path.string() + " is missing");
    return std::string();
  }
  const auto size = file_size(fd->get());
  if (!size) return size.error();
  if (*size != file.bytes) {
    damage.add(file.path.string() + " has " + std::to_string(*size) + " bytes, its record says " +
               std::to_string(file.bytes));
    return std::string();
  }
  return digest_of(*fd);
}

using Hashes = std::map<std::string, std::string>;

/// Reads every file and compares it with its record. Returns the hashes of unfinished uploads, by path.
Result<Hashes> check_files(const fs::path& folder, const std::vector<RecordedFile>& files, Damage& damage) {
  Hashes uploads;
  for (const RecordedFile& file : files) {
    const auto hash = hash_of(folder, file, damage);
    if (!hash) return hash.error();
    if (hash->empty()) continue;
    if (file.sha256.empty()) uploads.emplace(file.path.string(), *hash);
    if (!file.sha256.empty() && *hash != file.sha256) {
      damage.add(file.path.string() + " has the SHA-256 " + *hash + ", its record says " + file.sha256);
    }
  }
  return uploads;
}

Result<Hashes> check_all(const fs::path& folder, const char* records, const Recorded& recorded, Damage& damage) {
  const auto wrong = check_records(folder / records);
  if (!wrong) return wrong.error();
  for (const std::string& each : *wrong) damage.add(each);
  std::ifstream identity(folder / kIdentity);
  std::string store;
  if (!std::getline(identity, store) || store != recorded.store) {
    damage.add("its file 'store' is not that of jobs.sqlite");
  }
  return check_files(folder, recorded.files, damage);
}

BackupContents contents_of(const Recorded& recorded) {
  BackupContents contents{recorded.jobs, recorded.clouds, recorded.uploads, recorded.files.size(), 0};
  for (const RecordedFile& file : recorded.files) contents.bytes += file.bytes;
  return contents;
}

Result<std::string> hash_of_records(const fs::path& file) {
  const auto fd = open_regular(file);
  if (!fd) return fd.error();
  return digest_of(*fd);
}

/// Everything but the manifest, under the lease; the records have their unfinished name.
Result<Recorded> copy_all(const fs::path& data, const fs::path& target) {
  const auto lease = BackupLease::take(data);
  if (!lease) return lease.error();
  for (const fs::path& each : {target, target / "inputs", target / "outputs", target / "partial"}) {
    if (Status made = make_directory(each); !made.ok()) return made.error();
  }
  // First, so that a server that is started on an unfinished copy finds files that are not its own, and stops.
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(data / kIdentity, error);
  if (error) return system_error("look at " + (data / kIdentity).string(), error.value());
  if (Status copied = copy_file(data / kIdentity, target / kIdentity, bytes); !copied.ok()) return copied.error();
  const fs::path records = target / kUnfinishedRecords;
  if (Status copied = copy_records(data / kRecords, records); !copied.ok()) return copied.error();
  auto recorded = read_records(records);
  if (!recorded) return recorded;
  for (const RecordedFile& file : recorded->files) {
    if (Status copied = copy_file(data / file.path, target / file.path, file.bytes); !copied.ok()) {
      return copied.error();
    }
  }
  return recorded;
}

/// Gives the records their name, and writes what makes the copy a backup.
Status finish(const fs::path& target, const Recorded& recorded, const Hashes& uploads) {
  const fs::path unfinished = target / kUnfinishedRecords;
  const auto hash = hash_of_records(unfinished);
  if (!hash) return hash.error();
  const BackupContents contents = contents_of(recorded);
  const Json manifest{{"surfaced", version()},       {"made_at", to_rfc3339(now())},
                      {"store", recorded.store},     {"jobs", contents.jobs},
                      {"clouds", contents.clouds},   {"unfinished_uploads", contents.uploads},
                      {"files", contents.files},     {"bytes", contents.bytes},
                      {"jobs_sqlite_sha256", *hash}, {"upload_sha256", Json(uploads)}};
  if (::rename(unfinished.c_str(), (target / kRecords).c_str()) != 0) return system_error("name the records", errno);
  if (Status synced = sync_directory(target); !synced.ok()) return synced;
  return write_file_durably(target / kManifest, manifest.dump(2) + "\n");
}

/// What backup.json says of hashes.
struct Manifest {
  std::string records;
  Hashes uploads;
};

Result<Manifest> read_manifest(const fs::path& backup) {
  std::ifstream file(backup / kManifest);
  if (!file) {
    return Error{ErrorCode::malformed_input, "'" + backup.string() + "' is no finished backup: it has no " + kManifest +
                                                 "; it broke off, or a service was started on it"};
  }
  try {
    const Json json = Json::parse(file);
    return Manifest{json.at("jobs_sqlite_sha256").get<std::string>(), json.at("upload_sha256").get<Hashes>()};
  } catch (const Json::exception& wrong) {
    return Error{ErrorCode::malformed_input,
                 "'" + backup.string() + "': " + kManifest + " cannot be read: " + wrong.what()};
  }
}

Error wrong_target(const fs::path& target, const std::string& why) {
  return with_fault({ErrorCode::invalid_usage, "'" + target.string() + "'" + why},
                    {"TARGET", target.string(), "a folder that is empty or not there yet, outside of --data"});
}

/// A service removes what it finds in its folder and does not know: no backup would stay there.
bool is_within(const fs::path& inner, const fs::path& outer) {
  std::error_code error;
  const fs::path below = fs::weakly_canonical(inner, error);
  const fs::path above = fs::weakly_canonical(outer, error);
  return !above.empty() && std::ranges::mismatch(above, below).in1 == above.end();
}

Status check_target(const fs::path& target, const fs::path& data) {
  std::error_code error;
  if (target.empty()) return wrong_target(target, " is no name");
  if (is_within(target, data)) return wrong_target(target, " lies in the folder that is to be copied");
  // A link to nothing is there, too.
  if (fs::symlink_status(target, error).type() == fs::file_type::not_found) return Done{};
  if (!fs::is_directory(target, error)) return wrong_target(target, " is no folder");
  const bool empty = fs::is_empty(target, error);
  if (error) return wrong_target(target, " cannot be read: " + error.message());
  if (!empty) return wrong_target(target, " is not empty");
  return Done{};
}

Status sync_file(const fs::path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd || ::fsync(fd.get()) != 0) return system_error("make " + file.string() + " durable", errno);
  return Done{};
}

}  // namespace

Result<BackupContents> back_up(const fs::path& data, const fs::path& target) {
  if (Status right = check_target(target, data); !right.ok()) return right.error();
  std::error_code error;
  const char* const kService = "a folder on which a service was started";
  if (!fs::exists(data / kRecords, error)) {
    return with_fault({ErrorCode::invalid_usage, "there is no job store at '" + (data / kRecords).string() + "'"},
                      {"--data", data.string(), kService});
  }
  if (!fs::exists(data / kIdentity, error)) {
    return with_fault({ErrorCode::invalid_usage, "no service was ever started on '" + data.string() + "'"},
                      {"--data", data.string(), kService});
  }
  if (Status made = make_directory(target); !made.ok()) return wrong_target(target, ": " + made.error().detail);
  const auto recorded = copy_all(data, target);
  if (!recorded) return recorded.error();
  if (Status synced = sync_file(target / kUnfinishedRecords); !synced.ok()) return synced.error();
  if (Status synced = sync_folders(target); !synced.ok()) return synced.error();
  Damage damage;
  const auto uploads = check_all(target, kUnfinishedRecords, *recorded, damage);
  if (!uploads) return uploads.error();
  if (Status whole = damage.status(data); !whole.ok()) return whole.error();
  if (Status finished = finish(target, *recorded, *uploads); !finished.ok()) return finished.error();
  return contents_of(*recorded);
}

Result<BackupContents> verify_backup(const fs::path& backup) {
  const auto manifest = read_manifest(backup);
  if (!manifest) return manifest.error();
  Damage damage;
  const auto hash = hash_of_records(backup / kRecords);
  if (!hash) damage.add("jobs.sqlite is missing");
  if (hash && manifest->records != *hash) damage.add("jobs.sqlite is not the file that was copied");
  // Nothing that these records say could be relied on.
  if (Status same = damage.status(backup); !same.ok()) return same.error();
  const auto recorded = read_records(backup / kRecords);
  if (!recorded) return recorded.error();
  const auto uploads = check_all(backup, kRecords, *recorded, damage);
  if (!uploads) return uploads.error();
  for (const auto& [path, found] : *uploads) {
    const auto expected = manifest->uploads.find(path);
    if (expected == manifest->uploads.end() || expected->second != found) {
      damage.add(path + " is not what was copied");
    }
  }
  if (Status whole = damage.status(backup); !whole.ok()) return whole.error();
  return contents_of(*recorded);
}

Status end_backup(const fs::path& data) {
  if (::unlink((data / kManifest).c_str()) != 0) {
    return errno == ENOENT ? Status(Done{}) : Status(system_error("remove " + (data / kManifest).string(), errno));
  }
  return sync_directory(data);
}

}  // namespace surfaced
