// SPDX-License-Identifier: GPL-3.0-or-later
#include "platform/digest.hpp"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <new>

namespace surfaced {

void Digest::Free::operator()(evp_md_ctx_st* context) const { ::EVP_MD_CTX_free(context); }

std::optional<Digest> Digest::named(std::string_view name) {
  const EVP_MD* kind = nullptr;
  if (name == "sha1") kind = ::EVP_sha1();
  if (name == "sha256") kind = ::EVP_sha256();
  if (name == "sha512") kind = ::EVP_sha512();
  if (name == "md5") kind = ::EVP_md5();
  if (kind == nullptr) return std::nullopt;
  std::unique_ptr<evp_md_ctx_st, Free> context(::EVP_MD_CTX_new());
  if (!context || ::EVP_DigestInit_ex(context.get(), kind, nullptr) != 1) throw std::bad_alloc();
  return Digest(std::move(context));
}

void Digest::update(std::span<const std::byte> bytes) {
  if (::EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) != 1) throw std::bad_alloc();
}

std::string Digest::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned size = 0;
  if (::EVP_DigestFinal_ex(context_.get(), bytes.data(), &size) != 1) throw std::bad_alloc();
  return {reinterpret_cast<const char*>(bytes.data()), size};
}

std::string hmac_sha256(std::string_view key, std::string_view message) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned size = 0;
  const auto* made =
      ::HMAC(::EVP_sha256(), key.data(), static_cast<int>(key.size()),
             reinterpret_cast<const unsigned char*>(message.data()), message.size(), bytes.data(), &size);
  if (made == nullptr) throw std::bad_alloc();
  return {reinterpret_cast<const char*>(bytes.data()), size};
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() && ::CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace surfaced
