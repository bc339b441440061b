// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/base.hpp"
#include "http/body_decoder.hpp"
#include "http/connection.hpp"
#include "http/permits.hpp"
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
  std::shared_ptr<const DeferredResponse> deferred;
  /// The answer: bytes, and for outputs a stream behind them.
  int status = 0;
  std::string bytes;
  std::optional<BodyStream> stream;
  std::shared_ptr<const StreamingResponse> streaming;
  /// When both are written.
  After after = After::close;
  std::chrono::steady_clock::time_point began;
};

/// From the head of a request to the bytes of its answer.
class Engine {
 public:
  /// @param body_limit  decoded bytes of a request's body
  /// @param permits     for bodies that are on their way
  Engine(const Router& router, std::uint64_t body_limit, Permits& permits)
      : router_(router), body_limit_(body_limit), permits_(permits) {}

  /// Calls the handler of a request, which may read the body; an error in place of the head is answered as a problem.
  /// The connection is only read from.
  Exchange exchange(Connection& connection, const Result<RequestHead>& head) const;

  /// Puts the answer that was waited for into the exchange.
  static void finish(Exchange& exchange, Response response);

 private:
  const Router& router_;
  const std::uint64_t body_limit_;
  Permits& permits_;
  const BodyDecoder decoder_;
};

}  // namespace surfaced::http
