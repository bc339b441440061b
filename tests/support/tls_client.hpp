// SPDX-License-Identifier: GPL-3.0-or-later
// A client inside TLS that can be as rude as the plain one, and certificates made on the spot.
#pragma once

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "support/http_client.hpp"

namespace surfaced::testing {

/// Writes a key and a certificate that it signs itself, for this name.
inline void make_certificate(const std::filesystem::path& certificate, const std::filesystem::path& key,
                             const std::string& name, const char* pass_phrase = nullptr) {
  const std::unique_ptr<EVP_PKEY, decltype(&::EVP_PKEY_free)> pair(EVP_EC_gen("P-256"), &::EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&::X509_free)> made(::X509_new(), &::X509_free);
  ::X509_set_version(made.get(), 2);
  ::ASN1_INTEGER_set(::X509_get_serialNumber(made.get()), 1);
  ::X509_gmtime_adj(::X509_getm_notBefore(made.get()), -60);
  ::X509_gmtime_adj(::X509_getm_notAfter(made.get()), 3600);
  ::X509_set_pubkey(made.get(), pair.get());
  X509_NAME* const subject = ::X509_get_subject_name(made.get());
  ::X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>(name.c_str()), -1,
                               -1, 0);
  ::X509_set_issuer_name(made.get(), subject);
  ::X509_sign(made.get(), pair.get(), ::EVP_sha256());
  const auto open = [](const std::filesystem::path& file) {
    return std::unique_ptr<std::FILE, decltype(&std::fclose)>(std::fopen(file.c_str(), "w"), &std::fclose);
  };
  ::PEM_write_X509(open(certificate).get(), made.get());
  ::PEM_write_PrivateKey(open(key).get(), pair.get(), pass_phrase == nullptr ? nullptr : ::EVP_aes_128_cbc(), nullptr,
                         0, nullptr, const_cast<char*>(pass_phrase));
}

struct TlsChoice {
  int oldest = TLS1_2_VERSION;
  int newest = TLS1_3_VERSION;
  /// Protocols to offer, each with its length before it.
  std::string protocols{};
};

class TlsConnection : public RawConnection {
 public:
  /// Shakes hands; throws if the server does not want to.
  explicit TlsConnection(std::uint16_t port, const TlsChoice& choice = {})
      : RawConnection(port),
        context_(::SSL_CTX_new(::TLS_client_method()), &::SSL_CTX_free),
        ssl_(nullptr, &::SSL_free) {
    ::SSL_CTX_set_security_level(context_.get(), 0);
    ::SSL_CTX_set_min_proto_version(context_.get(), choice.oldest);
    ::SSL_CTX_set_max_proto_version(context_.get(), choice.newest);
    ssl_.reset(::SSL_new(context_.get()));
    ::SSL_set_fd(ssl_.get(), descriptor());
    if (!choice.protocols.empty()) {
      ::SSL_set_alpn_protos(ssl_.get(), reinterpret_cast<const unsigned char*>(choice.protocols.data()),
                            static_cast<unsigned>(choice.protocols.size()));
    }
    if (::SSL_connect(ssl_.get()) != 1) throw std::runtime_error("no handshake");
  }

  bool send(std::string_view bytes) override {
    while (!bytes.empty()) {
      const int count = ::SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
      if (count <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }

  std::string version() const { return ::SSL_get_version(ssl_.get()); }
  std::string protocol() const {
    const unsigned char* name = nullptr;
    unsigned size = 0;
    ::SSL_get0_alpn_selected(ssl_.get(), &name, &size);
    return {reinterpret_cast<const char*>(name), size};
  }
  std::string server_name() const {
    const std::unique_ptr<X509, decltype(&::X509_free)> shown(::SSL_get1_peer_certificate(ssl_.get()), &::X509_free);
    std::string name(64, '\0');
    const int size = ::X509_NAME_get_text_by_NID(::X509_get_subject_name(shown.get()), NID_commonName, name.data(),
                                                 static_cast<int>(name.size()));
    name.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return name;
  }
  /// The server has said goodbye: what came before is all of it.
  bool ended_properly() const { return (::SSL_get_shutdown(ssl_.get()) & SSL_RECEIVED_SHUTDOWN) != 0; }
  /// Asks for new keys, a message without data.
  bool change_keys() {
    return ::SSL_key_update(ssl_.get(), SSL_KEY_UPDATE_NOT_REQUESTED) == 1 && ::SSL_do_handshake(ssl_.get()) == 1;
  }

 protected:
  bool arrives_within(std::chrono::milliseconds patience) override {
    return ::SSL_pending(ssl_.get()) > 0 || RawConnection::arrives_within(patience);
  }
  ssize_t receive(char* bytes, std::size_t size) override {
    return ::SSL_read(ssl_.get(), bytes, static_cast<int>(size));
  }

 private:
  std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)> context_;
  std::unique_ptr<SSL, decltype(&::SSL_free)> ssl_;
};

}  // namespace surfaced::testing
