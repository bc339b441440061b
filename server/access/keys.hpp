// SPDX-License-Identifier: GPL-3.0-or-later
// API keys. A key is `sfd_ID_SECRET`; the file has, by id, the SHA-256 of the secret and what the key permits. The
// secret has 256 random bits, so a plain hash cannot be turned back by guessing, and needs no salt and no delay.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// What a key permits.
struct Scopes {
  /// GET what is the key's own.
  bool read = false;
  /// Send clouds and jobs, cancel and remove the key's own.
  bool submit = false;
  /// Everything, also what belongs to other keys.
  bool admin = false;
  /// GET /metrics, which counts the jobs of all keys; nothing else.
  bool metrics = false;
};
/// "read,submit"; invalid_usage for anything else.
Result<Scopes> scopes_named(std::string_view list);
std::vector<std::string> names_of(const Scopes& scopes);

/// What a key may use; 0 for no limit.
struct Quota {
  std::uint64_t requests_per_minute = 0;
  /// Of these, clouds, uploads and jobs that are sent.
  std::uint64_t submissions_per_minute = 0;
  /// Jobs that wait or run.
  std::uint64_t active_jobs = 0;
  /// Bytes of clouds and outputs.
  std::uint64_t stored_bytes = 0;
};

struct Key {
  std::string id;
  std::string name;
  std::string created_at;
  /// SHA-256 of the secret, in hexadecimal digits.
  std::string secret_sha256;
  Scopes scopes;
  Quota quota;
};

/// The keys of a file, by id.
class KeyRing {
 public:
  /// Reads the file; invalid_usage with its name and what is wrong.
  static Result<KeyRing> load(const std::filesystem::path& file);
  /// Writes it, for the owner alone, so that a reader sees the old file or the new one.
  Status save(const std::filesystem::path& file) const;

  /// Makes a key; returns its text, which is shown once and kept nowhere.
  std::string add(std::string name, const Scopes& scopes, const Quota& quota);
  bool remove(std::string_view id);

  /// The key with this text, or none. Takes as long for a wrong secret as for a right one.
  const Key* find(std::string_view text) const;
  const Key* with_id(std::string_view id) const;
  const std::map<std::string, Key, std::less<>>& all() const { return keys_; }

 private:
  std::map<std::string, Key, std::less<>> keys_;
};

}  // namespace surfaced
