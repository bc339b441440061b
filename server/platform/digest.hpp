// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace surfaced {

/// A digest by its name (OpenSSL): sha1, sha256, sha512, md5.
class Digest {
 public:
  /// None for a name that there is not.
  static std::optional<Digest> named(std::string_view name);
  void update(std::span<const std::byte> bytes);
  /// The raw bytes; to be called once.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  explicit Digest(std::unique_ptr<evp_md_ctx_st, Free> context) : context_(std::move(context)) {}
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// HMAC-SHA256, raw bytes.
std::string hmac_sha256(std::string_view key, std::string_view message);

/// Compares in a time that does not depend on where the two differ.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace surfaced
