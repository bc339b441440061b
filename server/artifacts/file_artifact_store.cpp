// SPDX-License-Identifier: GPL-3.0-or-later
#include "artifacts/file_artifact_store.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <optional>
#include <set>
#include <system_error>

#include "artifacts/backup_lease.hpp"
#include "base/sha256.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"
#include "platform/space.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;

std::string directory_of(const Claim& claim) { return claim.job + "-" + std::to_string(claim.attempt); }

class FileUpload final : public Upload {
 public:
  FileUpload(UniqueFd fd, fs::path temporary, fs::path inputs, SpaceLooks::Check check_space)
      : fd_(std::move(fd)),
        temporary_(std::move(temporary)),
        inputs_(std::move(inputs)),
        space_(std::move(check_space)) {}
  ~FileUpload() override {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  Status write(std::span<const std::byte> bytes) override {
    if (Status space = space_.before(bytes.size()); !space.ok()) return space;
    sha_.update(bytes);
    bytes_ += bytes.size();
    return write_all(fd_.get(), bytes, "store the upload");
  }

  std::uint64_t bytes() const override { return bytes_; }

  const std::string& sha256() override {
    if (digest_.empty()) digest_ = sha_.finish();
    return digest_;
  }

  Result<StoredInput> commit(std::string_view key) override {
    if (::fsync(fd_.get()) != 0) return system_error("store the upload", errno);
    const fs::path target = inputs_ / key;
    if (::rename(temporary_.c_str(), target.c_str()) != 0) return system_error("store the upload", errno);
    temporary_ = target;
    if (Status synced = sync_directory(inputs_); !synced.ok()) return synced.error();
    temporary_.clear();
    return StoredInput{std::string(key), bytes_, sha256()};
  }

 private:
  UniqueFd fd_;
  // Removed with this object; empty once the upload is committed.
  fs::path temporary_;
  fs::path inputs_;
  SpaceLooks space_;
  Sha256 sha_;
  std::string digest_;
  std::uint64_t bytes_ = 0;
};

class FileReader final : public OutputReader {
 public:
  FileReader(UniqueFd fd, std::uint64_t size) : fd_(std::move(fd)), size_(size) {}

  std::uint64_t size() const override { return size_; }

  Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> buffer) override {
    for (;;) {
      const ssize_t count = ::pread(fd_.get(), buffer.data(), buffer.size(), static_cast<off_t>(offset));
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR) return system_error("read an output", errno);
    }
  }

 private:
  UniqueFd fd_;
  std::uint64_t size_;
};

/// Makes one file that a child wrote durable and describes it; none if there is no such file.
Result<std::optional<Output>> seal(const fs::path& path, std::uint32_t attempt) {
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::not_found) return std::optional<Output>();
  if (type != fs::file_type::regular) {
    return Error{ErrorCode::crashed, "the process left something that is no file as " + path.filename().string()};
  }
  const Result<UniqueFd> fd = open_regular(path);
  if (!fd) return fd.error();
  const auto size = file_size(fd->get());
  if (!size) return size.error();
  auto sha = digest_of(*fd);
  if (!sha) return sha.error();
  if (::fsync(fd->get()) != 0) return system_error("keep an output", errno);
  return std::optional(Output{path.filename().string(), attempt, *size, std::move(*sha)});
}

class FileArtifactStore final : public ArtifactStore {
 public:
  FileArtifactStore(const fs::path& directory, std::uint64_t minimum_free)
      : directory_(directory),
        identity_(directory / "store"),
        uploads_(directory / "uploads"),
        inputs_(directory / "inputs"),
        attempts_(directory / "attempts"),
        outputs_(directory / "outputs"),
        minimum_free_(minimum_free) {}

  Status make_directories() {
    for (const fs::path* each : {&uploads_, &inputs_, &attempts_, &outputs_}) {
      if (Status made = make_directory(*each); !made.ok()) return made;
    }
    return Done{};
  }

  Result<std::unique_ptr<Upload>> begin_upload() override {
    fs::path temporary = uploads_ / random_hex<16>();
    UniqueFd fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!fd) return system_error("begin an upload", errno);
    return std::unique_ptr<Upload>(std::make_unique<FileUpload>(
        std::move(fd), std::move(temporary), inputs_, [this](std::uint64_t needed) { return check_space(needed); }));
  }

  Result<fs::path> input_file(std::string_view key) override { return inputs_ / key; }

  bool has_input(std::string_view key, std::uint64_t bytes) override {
    const auto fd = open_regular(inputs_ / key);
    if (!fd) return false;
    const auto size = file_size(fd->get());
    return size && *size == bytes;
  }

  Result<fs::path> begin_attempt(const Claim& claim) override {
    fs::path directory = attempts_ / directory_of(claim);
    if (::mkdir(directory.c_str(), 0700) != 0) return system_error("make the directory of an attempt", errno);
    return directory;
  }

  Result<std::vector<Output>> publish(const Claim& claim, std::span<const std::string> names) override {
    const fs::path directory = attempts_ / directory_of(claim);
    std::vector<Output> outputs;
    std::set<std::string, std::less<>> kept;
    for (const std::string& name : names) {
      auto output = seal(directory / name, claim.attempt);
      if (!output) return output.error();
      if (!output->has_value()) continue;
      kept.emplace(name);
      outputs.push_back(std::move(**output));
    }
    if (Status cleaned = remove_others(directory, kept); !cleaned.ok()) return cleaned.error();
    if (Status synced = sync_directory(directory); !synced.ok()) return synced.error();
    // A claim publishes once: what is there was left by a server that died before a record knew it.
    remove_tree(outputs_ / directory_of(claim));
    if (::rename(directory.c_str(), (outputs_ / directory_of(claim)).c_str()) != 0) {
      return system_error("publish the outputs", errno);
    }
    if (Status synced = sync_directory(outputs_); !synced.ok()) return synced.error();
    return outputs;
  }

  void discard(const Claim& claim) override {
    remove_tree(attempts_ / directory_of(claim));
    remove_tree(outputs_ / directory_of(claim));
  }

  Result<fs::path> output_file(const Claim& claim, std::string_view name) override {
    return outputs_ / directory_of(claim) / name;
  }

  Result<std::unique_ptr<OutputReader>> open_output(const Claim& claim, std::string_view name) override {
    auto fd = open_regular(outputs_ / directory_of(claim) / name);
    if (!fd) return fd.error();
    const auto size = file_size(fd->get());
    if (!size) return size.error();
    return std::unique_ptr<OutputReader>(std::make_unique<FileReader>(std::move(*fd), *size));
  }

  Result<std::unique_ptr<OutputReader>> open_log(const Claim& claim) override {
    // It moves from the one place to the other when the attempt ends.
    for (const fs::path* const place : {&attempts_, &outputs_}) {
      auto fd = open_regular(*place / directory_of(claim) / "log.txt");
      if (fd) return std::unique_ptr<OutputReader>(std::make_unique<FileReader>(std::move(*fd), 0));
    }
    return Error{ErrorCode::output_not_found,
                 "job " + claim.job + " has no log of attempt " + std::to_string(claim.attempt)};
  }

  void remove(const Artifacts& garbage) override {
    const auto lease = BackupLease::to_remove(directory_);
    if (!lease) return;
    for (const auto& key : garbage.inputs) remove_tree(inputs_ / key);
    for (const auto& claim : garbage.outputs) remove_tree(outputs_ / directory_of(claim));
  }

  Result<std::size_t> sweep(const Artifacts& kept) override {
    const std::set<std::string> inputs(kept.inputs.begin(), kept.inputs.end());
    std::set<std::string> outputs;
    for (const Claim& claim : kept.outputs) outputs.insert(directory_of(claim));
    std::size_t removed = 0;
    const auto sweep_one = [&](const fs::path& directory, const std::set<std::string>& keep) -> Status {
      const auto entries = entries_of(directory);
      if (!entries) return entries.error();
      for (const fs::path& entry : *entries) {
        if (keep.contains(entry.filename().string())) continue;
        remove_tree(entry);
        ++removed;
      }
      return Done{};
    };
    for (const fs::path& scratch : {uploads_, attempts_}) {
      if (Status swept = sweep_one(scratch, {}); !swept.ok()) return swept.error();
    }
    const auto lease = BackupLease::to_remove(directory_);
    if (!lease) return removed;
    if (Status swept = sweep_one(inputs_, inputs); !swept.ok()) return swept.error();
    if (Status swept = sweep_one(outputs_, outputs); !swept.ok()) return swept.error();
    return removed;
  }

  Result<Artifacts> listing() override {
    Artifacts found;
    const auto inputs = entries_of(inputs_);
    if (!inputs) return inputs.error();
    for (const fs::path& entry : *inputs) found.inputs.push_back(entry.filename());
    const auto outputs = entries_of(outputs_);
    if (!outputs) return outputs.error();
    for (const fs::path& entry : *outputs) {
      if (auto claim = claim_of(entry.filename())) found.outputs.push_back(std::move(*claim));
    }
    return found;
  }

  Status belong_to(std::string_view identity) override {
    std::error_code error;
    if (!fs::exists(identity_, error)) {
      if (Status written = write_file_durably(identity_, identity); !written.ok()) return written;
      return Done{};
    }
    std::ifstream file(identity_);
    std::string known;
    if (std::getline(file, known) && known == identity) return Done{};
    return Error{ErrorCode::invalid_usage, "the files under --data belong to the job store '" + known +
                                               "', but jobs.sqlite is '" + std::string(identity) +
                                               "'; put the right jobs.sqlite there, or remove the file 'store' to give "
                                               "up all files that no job of this one refers to"};
  }

  Status check_space(std::uint64_t needed) override {
    const std::uint64_t free = free_bytes();
    if (free >= minimum_free_ && free - minimum_free_ >= needed) return Done{};
    return Error{ErrorCode::storage_full, std::to_string(free) + " bytes are free under --data, " +
                                              std::to_string(needed) + " are needed, and " +
                                              std::to_string(minimum_free_) + " are to stay free"};
  }

  std::uint64_t free_bytes() override {
    struct statvfs disk {};
    // A disk that cannot be asked is as good as full.
    return ::statvfs(uploads_.c_str(), &disk) == 0 ? std::uint64_t{disk.f_bavail} * disk.f_frsize : 0;
  }

 private:
  // Best effort: what stays is swept at the next start.
  static void remove_tree(const fs::path& path) {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }

  static Status remove_others(const fs::path& directory, const std::set<std::string, std::less<>>& kept) {
    const auto entries = entries_of(directory);
    if (!entries) return entries.error();
    for (const fs::path& entry : *entries) {
      if (!kept.contains(entry.filename().string())) remove_tree(entry);
    }
    return Done{};
  }

  /// Reads what directory_of wrote.
  static std::optional<Claim> claim_of(const std::string& name) {
    const std::size_t dash = name.rfind('-');
    Claim claim;
    if (dash == name.npos) return std::nullopt;
    claim.job = name.substr(0, dash);
    const auto [end, failed] = std::from_chars(name.data() + dash + 1, name.data() + name.size(), claim.attempt);
    if (failed != std::errc() || end != name.data() + name.size()) return std::nullopt;
    return claim;
  }

  const fs::path directory_;
  const fs::path identity_;
  const fs::path uploads_;
  const fs::path inputs_;
  const fs::path attempts_;
  const fs::path outputs_;
  const std::uint64_t minimum_free_;
};

}  // namespace

Result<std::unique_ptr<ArtifactStore>> open_file_artifact_store(const fs::path& directory, std::uint64_t minimum_free) {
  auto store = std::make_unique<FileArtifactStore>(directory, minimum_free);
  if (Status made = store->make_directories(); !made.ok()) return made.error();
  return std::unique_ptr<ArtifactStore>(std::move(store));
}

}  // namespace surfaced
