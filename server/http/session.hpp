// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "http/connection.hpp"
#include "http/engine.hpp"
#include "http/unsent.hpp"

namespace surfaced::http {

/// A connection and what is going on on it:
///
///   Handshake (TLS) --(a thread of the pool: keys are exchanged)--> ReadingHead
///   Handshake (TLS) --(the client speaks plain HTTP, and is told)--> Lingering --> over
///   ReadingHead --complete--> (a thread of the pool: engine) --response--> Writing --keep--> ReadingHead
///                                 |            ^                             |---drain---> Lingering --> over
///                                 '-Deferred---'                             |---close---> over, or Lingering until
///                                                                            |             all is taken
///                                                 Streaming <--head written--'
///                                                 (a chunk after another, until the end: close)
///
/// It belongs to the event loop while it waits and to a thread of the pool while it is worked on; whoever has it
/// calls `advance`, which never blocks.
class Session {
 public:
  using Clock = Connection::Clock;
  enum class Step : std::uint8_t {
    /// It waits for `events` or for the deadline.
    waits,
    /// There is work for the pool: a handshake to go on with, a head to answer, or a response to ask for.
    ready,
    over,
  };

  /// @param id  of this connection, for as long as it lives
  /// @param open  counts the connections, this one until this object ends
  /// @param tls  none for plain HTTP
  Session(std::uint64_t id, UniqueFd fd, const ConnectionLimits& limits, std::size_t requests,
          std::atomic<std::size_t>& open, const Tls* tls);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::uint64_t id() const { return id_; }
  /// It waits for a response that is not known yet, or for the next chunk of one.
  bool waits_for_response() const;
  /// It streams a response, of which the next chunk may be there.
  bool waits_for_chunk() const;
  /// It has been answered, and only takes the rest of that.
  bool lingers() const { return std::holds_alternative<Lingering>(state_); }
  /// No request is there yet that would be owed an answer.
  bool before_request() const {
    return std::holds_alternative<Handshake>(state_) || std::holds_alternative<ReadingHead>(state_);
  }
  int descriptor() const { return connection_.descriptor(); }
  /// What epoll shall look for.
  std::uint32_t events() const;
  Clock::time_point deadline() const;

  /// Goes on as far as it can without waiting.
  Step advance();
  /// The deadline has passed.
  Step overdue();

  /// Goes on with the handshake, answers the head that has arrived, or asks for the response that was waited for.
  /// @param wake  tells the event loop that the session with this id may have its response; called by any thread
  /// @param stopping  the server answers what it has and ends the connection
  Step work(Engine& engine, const std::function<void(std::uint64_t id)>& wake, bool stopping);

  /// What the client has not taken of its answer.
  Unsent::Share share() const;
  /// The connection ends at once, with what the client has not taken.
  void give_up() const { connection_.give_up(); }

  /// Somebody woke it since the last poll: then the session does not go to sleep.
  bool woken() const { return *woken_; }

  /// What was answered since the last call, for the log.
  std::optional<Exchange> take_answered();

 private:
  struct Handshake {
    /// It goes on when the socket takes bytes, not when it has some.
    bool writes = false;
  };
  struct ReadingHead {
    /// Once it is complete, or cannot be.
    std::optional<Result<std::string>> head{};
  };
  struct Deferred {
    std::shared_ptr<const DeferredResponse> response;
    /// The deadline has passed: it has to answer now.
    bool last_poll = false;
    std::shared_ptr<void> subscription{};
  };
  /// Bytes on their way to the client, and a stream behind them.
  struct Writing {
    std::size_t sent = 0;
    std::uint64_t streamed = 0;
  };
  struct Streaming {
    std::shared_ptr<const StreamingResponse> response;
    /// Set while no chunk is being sent.
    std::optional<Clock::time_point> next_chunk{};
    std::string chunk{};
    std::size_t sent = 0;
    /// The chunk is the last.
    bool ended = false;
    /// None before the first chunk. Its pointer may be null.
    std::optional<std::shared_ptr<void>> subscription{};
  };
  struct Lingering {};
  using State = std::variant<Handshake, ReadingHead, Deferred, Writing, Streaming, Lingering>;

  Step advance(Handshake& state);
  Step advance(ReadingHead& state);
  Step advance(Deferred& state);
  Step advance(Writing& state);
  Step advance(Streaming& state);
  Step advance(Lingering& state);

  Step handshake();
  Step answer_head(Engine& engine, const std::function<void(std::uint64_t)>& wake, bool stopping);
  Step poll(Engine& engine, bool stopping);
  Step begin_writing();
  Step after_writing();
  /// Closes the connection once the client has taken all of the answer.
  Step end();
  Step begin_chunk(const std::function<void(std::uint64_t)>& wake, bool stopping);
  Step await_chunk();
  Step linger();
  /// Sends what is left of the bytes; none once that is all.
  std::optional<Step> send(std::string_view bytes, std::size_t& sent);
  /// What a subscription calls.
  std::function<void()> waker(const std::function<void(std::uint64_t)>& wake) const;

  const std::uint64_t id_;
  Connection connection_;
  std::atomic<std::size_t>& open_;
  std::size_t requests_left_;
  Exchange exchange_;
  bool answered_ = false;
  std::shared_ptr<std::atomic<bool>> woken_ = std::make_shared<std::atomic<bool>>(false);
  // Last, so that no subscription wakes what is half gone.
  State state_;
};

}  // namespace surfaced::http
