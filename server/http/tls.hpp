// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "base/base.hpp"

struct ssl_st;
struct ssl_ctx_st;

namespace surfaced::http {

/// Certificate and key of the server: TLS 1.2 and 1.3, ciphers with forward secrecy. Safe in threads. The process
/// ignores SIGPIPE.
class Tls {
 public:
  struct Files {
    /// PEM: the server's certificate first, then what leads to its root.
    std::filesystem::path certificate;
    /// PEM, without a pass phrase.
    std::filesystem::path key;
  };
  /// invalid_usage that names the file, if one cannot be read or they do not belong together.
  static Result<std::unique_ptr<Tls>> load(Files files);

  /// Reads the files again, for connections that begin from now on; after an error all stays as it was.
  Status reload();

  /// When the certificate ends, as OpenSSL writes it: "Nov 23 21:47:55 2026 GMT".
  std::string not_after() const;

 private:
  friend class TlsChannel;
  using Context = std::shared_ptr<ssl_ctx_st>;

  Tls(Files files, Context context) : files_(std::move(files)), context_(std::move(context)) {}
  static Result<Context> read(const Files& files);
  Context context() const;

  const Files files_;
  mutable std::mutex mutex_;
  Context context_;
};

/// The bytes of one connection inside TLS, on a socket that does not block. No call waits, and none reads more than one
/// record, so that a client cannot keep a thread busy by what it sends inside the protocol.
class TlsChannel {
 public:
  /// @param descriptor  stays the caller's, and open longer than this object
  TlsChannel(const Tls& tls, int descriptor);
  /// Says goodbye if the handshake was done and nothing went wrong.
  ~TlsChannel();
  TlsChannel(const TlsChannel&) = delete;
  TlsChannel& operator=(const TlsChannel&) = delete;

  enum class Handshake : std::uint8_t {
    done,
    /// It goes on when bytes have arrived.
    reads,
    /// It goes on when the socket takes bytes.
    writes,
    /// The client speaks HTTP without TLS.
    plain,
    failed,
  };
  /// Goes on with the handshake.
  Handshake handshake();
  /// Why it failed.
  const std::string& why() const { return why_; }

  /// As recv: the number of bytes, 0 at the end or if the client broke the rules, -1 if nothing is there now.
  std::ptrdiff_t receive(char* bytes, std::size_t size);
  /// As send: the number of bytes, 0 if nothing is taken now, -1 if the client is gone. If not all are taken, the next
  /// call has to offer what is left of them, and may offer more behind it.
  std::ptrdiff_t send(const char* bytes, std::size_t size);
  /// Tells the client that nothing more follows.
  void end();

 private:
  struct Free {
    void operator()(ssl_st* ssl) const;
  };
  // Outlives what was made from it.
  const Tls::Context context_;
  const std::unique_ptr<ssl_st, Free> ssl_;
  std::string why_;
  bool established_ = false;
  bool over_ = false;
};

}  // namespace surfaced::http
