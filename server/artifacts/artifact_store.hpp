// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "jobs/job.hpp"
#include "jobs/job_store.hpp"

namespace surfaced {

/// A cloud on its way in. Dropped before `commit`, nothing of it stays.
class Upload {
 public:
  Upload() = default;
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;
  virtual ~Upload() = default;

  virtual Status write(std::span<const std::byte> bytes) = 0;
  virtual std::uint64_t bytes() const = 0;

  /// SHA-256 of what was written; nothing can be written after it.
  virtual const std::string& sha256() = 0;

  /// Keeps the cloud under this key; it is durable when the call returns.
  virtual Result<StoredInput> commit(std::string_view key) = 0;
};

/// An output that is being read.
class OutputReader {
 public:
  OutputReader() = default;
  OutputReader(const OutputReader&) = delete;
  OutputReader& operator=(const OutputReader&) = delete;
  virtual ~OutputReader() = default;

  virtual std::uint64_t size() const = 0;
  /// Reads up to buffer.size() bytes at the offset; 0 at the end.
  virtual Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> buffer) = 0;
};

/// Where clouds and outputs are kept: inputs under a key, outputs under (job, attempt, name). What
/// exists counts only once the job store refers to it; `sweep` removes what it does not refer to.
/// All calls are safe in threads.
class ArtifactStore {
 public:
  ArtifactStore() = default;
  ArtifactStore(const ArtifactStore&) = delete;
  ArtifactStore& operator=(const ArtifactStore&) = delete;
  virtual ~ArtifactStore() = default;

  virtual Result<std::unique_ptr<Upload>> begin_upload() = 0;

  /// The cloud as a local file, for a child to read.
  virtual Result<std::filesystem::path> input_file(std::string_view key) = 0;

  /// True if the cloud is there with all its bytes.
  virtual bool has_input(std::string_view key, std::uint64_t bytes) = 0;

  /// An empty local directory for an attempt to write into.
  virtual Result<std::filesystem::path> begin_attempt(const Claim& claim) = 0;

  /// Keeps the named files of the attempt's directory, durable when the call returns, and drops the
  /// rest of it. Names that are absent are left out of the answer; `crashed` for a name that is no regular file.
  virtual Result<std::vector<Output>> publish(const Claim& claim, std::span<const std::string> names) = 0;

  /// Drops the attempt's directory, and what it may have published.
  virtual void discard(const Claim& claim) = 0;

  /// A published output as a local file, for a child to read.
  virtual Result<std::filesystem::path> output_file(const Claim& claim, std::string_view name) = 0;

  virtual Result<std::unique_ptr<OutputReader>> open_output(const Claim& claim, std::string_view name) = 0;

  /// log.txt of an attempt, published or still being written.
  virtual Result<std::unique_ptr<OutputReader>> open_log(const Claim& claim) = 0;

  /// Drops inputs and outputs that no job refers to any more. What cannot be dropped now, because a backup is being
  /// made say, is left to sweeps.
  virtual void remove(const Artifacts& garbage) = 0;

  /// Removes everything that the job store does not refer to; during a backup only what was on its way. To be called
  /// at start, before uploads and attempts begin. Returns how many files and directories it removed.
  virtual Result<std::size_t> sweep(const Artifacts& kept) = 0;

  /// What is there now: keys of inputs and claims of published outputs, for a sweep while the store is in use.
  virtual Result<Artifacts> listing() = 0;

  /// Ties the store to a job store for good, so that a sweep never meets the files of another one.
  /// @return  invalid_usage if it belongs to another
  virtual Status belong_to(std::string_view identity) = 0;

  /// storage_full if less space would be left than a server needs to go on, were this many bytes stored.
  virtual Status check_space(std::uint64_t needed) = 0;

  /// Bytes that may still be written, those included that are to stay free.
  virtual std::uint64_t free_bytes() = 0;
};

}  // namespace surfaced
