// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

struct evp_md_ctx_st;

namespace surfaced {

/// SHA-256 of bytes that arrive in pieces (OpenSSL).
class Sha256 {
 public:
  Sha256();
  void update(std::span<const std::byte> bytes);
  /// 64 lower-case hexadecimal digits; to be called once.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Bytes as lower-case hexadecimal digits.
std::string to_hex(std::span<const std::byte> bytes);

/// SHA-256 of an open file, read from its beginning; none, with errno, if it cannot be read.
std::optional<std::string> sha256_of_file(int fd);

}  // namespace surfaced
