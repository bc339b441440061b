// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/base.hpp"
#include "http/connection.hpp"
#include "http/places.hpp"
#include "http/request_head.hpp"
#include "http/router.hpp"

namespace surfaced::http {

/// What is to be done with the connection after an answer.
enum class After : std::uint8_t {
  /// It can take another request.
  keep,
  close,
  /// Close it, but the client may still be sending what nobody reads.
  drain,
};

/// A request that is being answered, and its answer.
struct Exchange {
  Request request;
  /// Set instead of an answer while that is not known.
  std::shared_ptr<const Later> later;
  /// The answer: bytes, and for outputs a stream behind them.
  int status = 0;
  std::string bytes;
  std::optional<BodyStream> stream;
  std::shared_ptr<const Feed> feed;
  /// When both are written.
  After after = After::close;
  std::chrono::steady_clock::time_point began;
};

/// The one place where cpp-httplib is used (engine.cpp): it decodes the bodies of requests and writes
/// responses. Version 0.11.4 cannot be shown to the network as it is, so it sees neither the socket nor
/// what the client wrote, but a request line and a body length made here from a head that has already
/// been read, judged and bounded (request_head.hpp, connection.hpp, chunk_guard.hpp):
///
///   trap of the library                             what stands before it
///   endless header lines, endless headers           Connection::read_head: bytes and one deadline
///   Content-Length together with Transfer-Encoding  parse_head refuses
///   header values are percent-decoded               our Headers are the client's; the library gets none
///   `REMOTE_ADDR:` of a client is believed          the address is the socket's
///   Range by regular expression, 500 ranges         the library sees no Range; http/conditional.hpp serves one
///   paths matched by regular expressions            the library sees `/`; http/router.hpp routes
///   gzip and brotli bodies inflate in memory        a Content-Encoding is refused; the library sees none
///   chunked bodies pass the limit, and are read     ChunkGuard, and a counter of decoded bytes
///     without care
///   unread bodies stay in the connection            it is closed, after a short drain
///   an exception's text leaks in a header           the router catches; so does this engine
///   accept() without CLOEXEC, SO_REUSEPORT,         http/server.hpp listens and accepts itself
///     backlog 5, an unbounded queue
///   select() and FD_SETSIZE                         epoll in http/lobby.hpp, poll in Connection
///   a client that takes its answer slowly holds     the library writes into memory, and of outputs only the head
///     a thread
class Engine {
 public:
  /// @param body_limit  decoded bytes of a request's body
  /// @param places      for bodies that are on their way
  Engine(const Router& router, std::uint64_t body_limit, Places& places);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Reads the body of a request and calls its handler; an error in place of the head is answered as a problem.
  /// The connection is only read from.
  Exchange exchange(Connection& connection, const Result<RequestHead>& head);

  /// Puts the answer that was waited for into the exchange.
  void finish(Exchange& exchange, Response response);

 private:
  class Library;
  const Router& router_;
  const std::uint64_t body_limit_;
  Places& places_;
  std::unique_ptr<Library> library_;
};

}  // namespace surfaced::http
