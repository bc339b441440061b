// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/tls.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <climits>
#include <new>
#include <string_view>

namespace surfaced::http {
namespace {

/// What HTTP/1.1 is called in the negotiation of protocols, with its length before it.
constexpr std::string_view kProtocol = "\x08http/1.1";

/// The last thing that OpenSSL complained of on this thread.
std::string complaint() {
  const unsigned long code = ::ERR_peek_last_error();
  const char* const reason = code == 0 ? nullptr : ::ERR_reason_error_string(code);
  ::ERR_clear_error();
  return reason == nullptr ? "the client broke off" : reason;
}

/// Whoever offers protocols and not ours is told so; clients that offer none speak ours.
int choose_protocol(SSL* /*ssl*/, const unsigned char** chosen, unsigned char* size, const unsigned char* offered,
                    unsigned int offered_size, void* /*unused*/) {
  unsigned char* out = nullptr;
  const auto* const ours = reinterpret_cast<const unsigned char*>(kProtocol.data());
  if (::SSL_select_next_proto(&out, size, ours, kProtocol.size(), offered, offered_size) != OPENSSL_NPN_NEGOTIATED) {
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  }
  *chosen = out;
  return SSL_TLSEXT_ERR_OK;
}

/// A key with a pass phrase is refused; nobody sits at the terminal of a server.
int no_pass_phrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*unused*/) { return -1; }

void set_rules(SSL_CTX* context) {
  ::SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  ::SSL_CTX_set_cipher_list(context, "ECDHE+AESGCM:ECDHE+CHACHA20");
  ::SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  // Whoever comes again brings a ticket; nothing is remembered here.
  ::SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  ::SSL_CTX_set_mode(context,
                     SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
  // A record without data (an endless row of key updates) ends the call, as the header promises.
  ::SSL_CTX_clear_mode(context, SSL_MODE_AUTO_RETRY);
  ::SSL_CTX_set_default_passwd_cb(context, no_pass_phrase);
  ::SSL_CTX_set_alpn_select_cb(context, choose_protocol, nullptr);
}

Error wrong_file(std::string_view setting, const std::filesystem::path& file, const std::string& why) {
  return with_fault(
      {ErrorCode::invalid_usage, "--" + std::string(setting) + " " + file.string() + " cannot be used: " + why},
      {std::string(setting), file.string(), "a PEM file"});
}

}  // namespace

Result<Tls::Context> Tls::read(const Files& files) {
  ::ERR_clear_error();
  const Context context(::SSL_CTX_new(::TLS_server_method()), &::SSL_CTX_free);
  if (!context) throw std::bad_alloc();
  set_rules(context.get());
  if (::SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1) {
    return wrong_file("tls-certificate", files.certificate, complaint());
  }
  if (::SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      ::SSL_CTX_check_private_key(context.get()) != 1) {
    return wrong_file("tls-key", files.key, complaint());
  }
  return context;
}

Result<std::unique_ptr<Tls>> Tls::load(Files files) {
  auto context = read(files);
  if (!context) return std::move(context).error();
  return std::unique_ptr<Tls>(new Tls(std::move(files), std::move(*context)));
}

Status Tls::reload() {
  auto context = read(files_);
  if (!context) return std::move(context).error();
  const std::scoped_lock lock(mutex_);
  context_ = std::move(*context);
  return Done{};
}

Tls::Context Tls::context() const {
  const std::scoped_lock lock(mutex_);
  return context_;
}

std::string Tls::not_after() const {
  const Context current = context();
  const std::unique_ptr<BIO, decltype(&::BIO_free_all)> text(::BIO_new(::BIO_s_mem()), &::BIO_free_all);
  const X509* const certificate = ::SSL_CTX_get0_certificate(current.get());
  if (!text || certificate == nullptr) return {};
  ::ASN1_TIME_print(text.get(), ::X509_get0_notAfter(certificate));
  char* bytes = nullptr;
  const long size = ::BIO_get_mem_data(text.get(), &bytes);
  return {bytes, static_cast<std::size_t>(std::max(0L, size))};
}

void TlsChannel::Free::operator()(ssl_st* ssl) const { ::SSL_free(ssl); }

TlsChannel::TlsChannel(const Tls& tls, int descriptor) : context_(tls.context()), ssl_(::SSL_new(context_.get())) {
  if (!ssl_ || ::SSL_set_fd(ssl_.get(), descriptor) != 1) throw std::bad_alloc();
  ::SSL_set_accept_state(ssl_.get());
}

TlsChannel::~TlsChannel() { end(); }

TlsChannel::Handshake TlsChannel::handshake() {
  ::ERR_clear_error();
  const int result = ::SSL_do_handshake(ssl_.get());
  if (result == 1) {
    established_ = true;
    return Handshake::done;
  }
  const int kind = ::SSL_get_error(ssl_.get(), result);
  if (kind == SSL_ERROR_WANT_READ) return Handshake::reads;
  if (kind == SSL_ERROR_WANT_WRITE) return Handshake::writes;
  over_ = true;
  const bool plain = ::ERR_GET_REASON(::ERR_peek_last_error()) == SSL_R_HTTP_REQUEST;
  why_ = complaint();
  return plain ? Handshake::plain : Handshake::failed;
}

std::ptrdiff_t TlsChannel::receive(char* bytes, std::size_t size) {
  if (over_) return 0;
  ::ERR_clear_error();
  const int count = ::SSL_read(ssl_.get(), bytes, static_cast<int>(std::min<std::size_t>(size, INT_MAX)));
  if (count > 0) return count;
  const int kind = ::SSL_get_error(ssl_.get(), count);
  if (kind == SSL_ERROR_WANT_READ || kind == SSL_ERROR_WANT_WRITE) return -1;
  // After a goodbye of the client's an answer can still be sent, after anything else not.
  over_ = kind != SSL_ERROR_ZERO_RETURN;
  ::ERR_clear_error();
  return 0;
}

std::ptrdiff_t TlsChannel::send(const char* bytes, std::size_t size) {
  std::size_t sent = 0;
  while (!over_ && sent < size) {
    ::ERR_clear_error();
    // One record a call.
    const int count =
        ::SSL_write(ssl_.get(), bytes + sent, static_cast<int>(std::min<std::size_t>(size - sent, INT_MAX)));
    if (count > 0) {
      sent += static_cast<std::size_t>(count);
      continue;
    }
    const int kind = ::SSL_get_error(ssl_.get(), count);
    if (kind == SSL_ERROR_WANT_READ || kind == SSL_ERROR_WANT_WRITE) break;
    over_ = true;
    ::ERR_clear_error();
  }
  return sent > 0 || !over_ ? static_cast<std::ptrdiff_t>(sent) : -1;
}

void TlsChannel::end() {
  if (!established_ || over_) return;
  over_ = true;
  ::ERR_clear_error();
  // Only the own goodbye; that of the client is not waited for.
  ::SSL_shutdown(ssl_.get());
  ::ERR_clear_error();
}

}  // namespace surfaced::http
