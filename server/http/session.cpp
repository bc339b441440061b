// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/session.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <vector>

#include "http/request_head.hpp"
#include "observability/log.hpp"

namespace surfaced::http {
namespace {

constexpr std::size_t kSendBytes = std::size_t{16} << 10;
/// What one connection may write before another one has its turn.
constexpr std::uint64_t kTurnBytes = std::uint64_t{256} << 10;

}  // namespace

Session::Session(std::uint64_t id, UniqueFd fd, const ConnectionLimits& limits, std::size_t requests,
                 std::atomic<std::size_t>& places, const Tls* tls)
    : id_(id),
      connection_(std::move(fd), limits, tls),
      places_(places),
      requests_left_(requests),
      state_(tls == nullptr ? State::head : State::greeting) {
  ++places_;
}

Session::~Session() { --places_; }

std::uint32_t Session::events() const {
  switch (state_) {
    case State::greeting:
      return greeting_writes_ ? EPOLLOUT : EPOLLIN | EPOLLRDHUP;
    case State::writing:
      return EPOLLOUT;
    case State::waiting:
      // What the client sends meanwhile stays in the socket; that it goes away is worth knowing.
      return EPOLLRDHUP;
    default:
      return EPOLLIN | EPOLLRDHUP;
  }
}

Session::Clock::time_point Session::deadline() const {
  switch (state_) {
    case State::greeting:
    case State::head:
      return connection_.head_deadline();
    case State::waiting:
      return exchange_.feed ? next_piece_ : exchange_.later->deadline;
    case State::writing:
      return connection_.transfer_deadline();
    default:
      return connection_.linger_deadline();
  }
}

Session::Step Session::advance() {
  switch (state_) {
    case State::greeting:
      // The arithmetic of a handshake is too much for the one thread that all wait in.
      return greeting_writes_ || connection_.has_news() ? Step::ready : Step::waits;
    case State::head: {
      auto arrival = connection_.take_head();
      if (std::holds_alternative<Connection::Incomplete>(arrival)) return Step::waits;
      if (std::holds_alternative<Connection::Closed>(arrival)) return Step::over;
      head_ = std::get<Result<std::string>>(std::move(arrival));
      return Step::ready;
    }
    case State::waiting:
      // The only event that it looks for: the client is gone.
      return Step::over;
    case State::writing:
      return write_on();
    default:
      return connection_.drop_arrived() ? Step::waits : Step::over;
  }
}

Session::Step Session::overdue() {
  if (state_ == State::waiting) {
    last_look_ = !exchange_.feed;
    return Step::ready;
  }
  if (state_ == State::head && connection_.wait_for_taking()) return Step::waits;
  if (state_ == State::lingering && connection_.is_still_taking()) return Step::waits;
  auto error = state_ == State::head ? connection_.head_overdue() : std::nullopt;
  if (!error) {
    // Nobody waits for what it has not taken by now, in the buffers of the kernel least of all.
    if (connection_.queued() > 0) connection_.give_up();
    return Step::over;
  }
  head_ = Result<std::string>(std::move(*error));
  return Step::ready;
}

Session::Step Session::greet() {
  using Greeting = TlsChannel::Greeting;
  const Greeting greeting = connection_.greet();
  greeting_writes_ = greeting == Greeting::writes;
  if (greeting == Greeting::reads || greeting == Greeting::writes) return Step::waits;
  if (greeting != Greeting::done) {
    log(LogLevel::debug, "a TLS handshake failed",
        {{"client", connection_.remote_address()}, {"detail", connection_.greeting_failure()}});
    if (greeting != Greeting::plain) return Step::over;
    // Closed with something unread, the socket would take the answer back.
    state_ = State::lingering;
    connection_.begin_linger();
    return advance();
  }
  state_ = State::head;
  // The head often comes in the client's last bytes of the handshake.
  return advance();
}

Session::Step Session::work(Engine& engine, const std::function<void(std::uint64_t)>& ring, bool stopping) {
  if (state_ == State::greeting) return greet();
  if (state_ == State::waiting && exchange_.feed) {
    // The ring may come from the subscription itself, which the first piece begins.
    if (!std::exchange(subscribed_, true)) {
      subscription_ = exchange_.feed->subscribe([ring, id = id_, rung = rung_] {
        rung->store(true);
        ring(id);
      });
    }
    return feed_on(stopping);
  }
  if (state_ == State::waiting) {
    last_look_ |= stopping;
  } else {
    const Result<std::string> text = *std::exchange(head_, std::nullopt);
    auto head = text ? parse_head(*text) : Result<RequestHead>(text.error());
    if (head && (--requests_left_ == 0 || stopping)) head->close = true;
    exchange_ = engine.exchange(connection_, head);
    if (!exchange_.later) return begin_writing();
    last_look_ = stopping;
    subscription_ = exchange_.later->subscribe([ring, id = id_, rung = rung_] {
      rung->store(true);
      ring(id);
    });
    state_ = State::waiting;
  }
  rung_->store(false);
  std::optional<Response> response = exchange_.later->look(last_look_ || Clock::now() >= exchange_.later->deadline);
  if (!response) return Step::waits;
  subscription_.reset();
  if (stopping && exchange_.after == After::keep) exchange_.after = After::close;
  engine.finish(exchange_, std::move(*response));
  return begin_writing();
}

Unsent::Share Session::share() const {
  const std::uint64_t queued = connection_.queued();
  return {state_ == State::writing ? exchange_.bytes.size() - sent_ : 0, queued, connection_.handed_over() - queued};
}

std::optional<Exchange> Session::take_answered() {
  if (!std::exchange(answered_, false)) return std::nullopt;
  Exchange told;
  told.request = exchange_.request;
  told.status = exchange_.status;
  told.began = exchange_.began;
  return told;
}

Session::Step Session::begin_writing() {
  state_ = State::writing;
  answered_ = true;
  sent_ = 0;
  streamed_ = 0;
  // The client's pace counts anew: what the handler took (it may have waited for a job) is not its time.
  connection_.begin_transfer();
  return write_on();
}

Session::Step Session::write_on() {
  while (sent_ < exchange_.bytes.size()) {
    const std::size_t wanted = std::min(kSendBytes, exchange_.bytes.size() - sent_);
    const auto count = connection_.try_send(exchange_.bytes.data() + sent_, wanted);
    if (count < 0) return Step::over;
    if (count == 0) return Step::waits;
    sent_ += static_cast<std::size_t>(count);
  }
  if (!exchange_.stream) return after_writing();
  thread_local std::vector<std::byte> buffer(kSendBytes);
  for (std::uint64_t turn = 0; streamed_ < exchange_.stream->length; turn += buffer.size()) {
    if (turn >= kTurnBytes) return Step::waits;
    const auto wanted = std::min<std::uint64_t>(buffer.size(), exchange_.stream->length - streamed_);
    const auto read = exchange_.stream->read(streamed_, std::span(buffer).first(wanted));
    // The head is sent, so a failure can only be shown by breaking off.
    if (!read || *read == 0) return Step::over;
    const auto count = connection_.try_send(reinterpret_cast<const char*>(buffer.data()), *read);
    if (count < 0) return Step::over;
    streamed_ += static_cast<std::uint64_t>(count);
    if (static_cast<std::size_t>(count) < *read) return Step::waits;
  }
  return after_writing();
}

Session::Step Session::feed_on(bool stopping) {
  rung_->store(false);
  Feed::Piece piece = exchange_.feed->next(stopping);
  feed_ended_ = piece.end || stopping;
  if (piece.more) rung_->store(true);
  exchange_.bytes = std::move(piece.bytes);
  state_ = State::writing;
  sent_ = 0;
  connection_.begin_transfer();
  return write_on();
}

Session::Step Session::await_feed() {
  exchange_.bytes = {};
  if (feed_ended_) return end();
  state_ = State::waiting;
  next_piece_ = Clock::now() + exchange_.feed->interval;
  // The first piece is there at once, and what was rung for while something was written.
  return !subscribed_ || rung() ? Step::ready : Step::waits;
}

Session::Step Session::end() {
  if (connection_.queued() == 0) return Step::over;
  state_ = State::lingering;
  connection_.begin_last_taking();
  return advance();
}

Session::Step Session::after_writing() {
  if (exchange_.feed) return await_feed();
  const After after = exchange_.after;
  exchange_.bytes = {};
  exchange_.stream.reset();
  if (after == After::close) return end();
  if (after == After::drain) {
    state_ = State::lingering;
    connection_.begin_linger();
  } else {
    state_ = State::head;
    connection_.expect_head();
  }
  return advance();
}

}  // namespace surfaced::http
