// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "http/connection.hpp"
#include "http/engine.hpp"
#include "http/unsent.hpp"

namespace surfaced::http {

/// A connection and what is going on on it:
///
///   greeting (TLS) --(a thread of the pool: keys are exchanged)--> head
///   greeting (TLS) --(the client speaks plain HTTP, and is told)--> lingering --> over
///   head --arrived--> (a thread of the pool: engine) --answer--> writing --keep--> head
///                          |          ^                             |---drain---> lingering --> over
///                          '--later-> waiting <--feed, until its end--+---close---> over, or lingering until all is
///                          taken
///
/// It belongs to the lobby while it waits and to a thread of the pool while it is worked on; whoever has it
/// calls `advance`, which never blocks.
class Session {
 public:
  using Clock = Connection::Clock;
  enum class State : std::uint8_t { greeting, head, waiting, writing, lingering };
  enum class Step : std::uint8_t {
    /// It waits for `events` or for the deadline.
    waits,
    /// There is work for the pool: a handshake to go on with, a head to answer, or an answer to look for.
    ready,
    over,
  };

  /// @param id  of this connection, for as long as it lives
  /// @param places  counts the connections; one is given back when this object ends
  /// @param tls  none for plain HTTP
  Session(std::uint64_t id, UniqueFd fd, const ConnectionLimits& limits, std::size_t requests,
          std::atomic<std::size_t>& places, const Tls* tls);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::uint64_t id() const { return id_; }
  State state() const { return state_; }
  /// It follows something, and has something new to send.
  bool feeds() const { return state_ == State::waiting && exchange_.feed != nullptr; }
  /// It has been answered, and only takes the rest of that.
  bool lingers() const { return state_ == State::lingering; }
  /// No request is there yet that would be owed an answer.
  bool before_request() const { return state_ == State::greeting || state_ == State::head; }
  int descriptor() const { return connection_.descriptor(); }
  /// What epoll shall look for.
  std::uint32_t events() const;
  Clock::time_point deadline() const;

  /// Goes on as far as it can without waiting.
  Step advance();
  /// The deadline has passed.
  Step overdue();

  /// Goes on with the handshake, answers the head that has arrived, or looks for the answer that was waited for.
  /// @param ring  tells the lobby that the session with this id may have its answer; called by any thread
  /// @param stopping  the server answers what it has and ends the connection
  Step work(Engine& engine, const std::function<void(std::uint64_t id)>& ring, bool stopping);

  /// What the client has not taken of its answer.
  Unsent::Share share() const;
  /// The connection ends at once, with what the client has not taken.
  void give_up() const { connection_.give_up(); }

  /// Somebody rang since the last look: then the session does not go to sleep.
  bool rung() const { return *rung_; }

  /// What was answered since the last call, for the log.
  std::optional<Exchange> take_answered();

 private:
  Step greet();
  Step begin_writing();
  Step write_on();
  Step after_writing();
  /// Closes the connection once the client has taken all of the answer.
  Step end();
  Step feed_on(bool stopping);
  Step await_feed();

  const std::uint64_t id_;
  Connection connection_;
  std::atomic<std::size_t>& places_;
  std::size_t requests_left_;
  State state_;
  // The handshake goes on when the socket takes bytes, not when it has some.
  bool greeting_writes_ = false;
  std::optional<Result<std::string>> head_;
  Exchange exchange_;
  std::size_t sent_ = 0;
  std::uint64_t streamed_ = 0;
  bool last_look_ = false;
  // Of a feed.
  Clock::time_point next_piece_;
  bool feed_ended_ = false;
  // Not told from the subscription, whose pointer may be null.
  bool subscribed_ = false;
  bool answered_ = false;
  std::shared_ptr<std::atomic<bool>> rung_ = std::make_shared<std::atomic<bool>>(false);
  // Last, so that nobody wakes what is half gone.
  std::shared_ptr<void> subscription_;
};

}  // namespace surfaced::http
