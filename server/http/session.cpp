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

template <class... Each>
struct Overloaded : Each... {
  using Each::operator()...;
};

}  // namespace

Session::Session(std::uint64_t id, UniqueFd fd, const ConnectionLimits& limits, std::size_t requests,
                 std::atomic<std::size_t>& open, const Tls* tls)
    : id_(id),
      connection_(std::move(fd), limits, tls),
      open_(open),
      requests_left_(requests),
      state_(tls == nullptr ? State(ReadingHead{}) : State(Handshake{})) {
  ++open_;
}

Session::~Session() { --open_; }

bool Session::waits_for_chunk() const {
  const auto* const streaming = std::get_if<Streaming>(&state_);
  return streaming != nullptr && streaming->next_chunk.has_value();
}

bool Session::waits_for_response() const { return std::holds_alternative<Deferred>(state_) || waits_for_chunk(); }

std::uint32_t Session::events() const {
  // What the client sends while it waits for its response stays in the socket; that it goes away is worth knowing.
  if (waits_for_response()) return EPOLLRDHUP;
  if (std::holds_alternative<Writing>(state_) || std::holds_alternative<Streaming>(state_)) return EPOLLOUT;
  const auto* const handshake = std::get_if<Handshake>(&state_);
  return handshake != nullptr && handshake->writes ? EPOLLOUT : EPOLLIN | EPOLLRDHUP;
}

Session::Clock::time_point Session::deadline() const {
  return std::visit(
      Overloaded{[&](const Handshake&) { return connection_.head_deadline(); },
                 [&](const ReadingHead&) { return connection_.head_deadline(); },
                 [&](const Deferred& state) { return state.response->deadline; },
                 [&](const Writing&) { return connection_.transfer_deadline(); },
                 [&](const Streaming& state) { return state.next_chunk.value_or(connection_.transfer_deadline()); },
                 [&](const Lingering&) { return connection_.linger_deadline(); }},
      state_);
}

Session::Step Session::advance() {
  return std::visit([this](auto& state) { return advance(state); }, state_);
}

Session::Step Session::advance(Handshake& state) {
  // The arithmetic of a handshake is too much for the one thread that all wait in.
  return state.writes || connection_.has_news() ? Step::ready : Step::waits;
}

Session::Step Session::advance(ReadingHead& state) {
  auto arrival = connection_.take_head();
  if (std::holds_alternative<Connection::Incomplete>(arrival)) return Step::waits;
  if (std::holds_alternative<Connection::Closed>(arrival)) return Step::over;
  state.head = std::get<Result<std::string>>(std::move(arrival));
  return Step::ready;
}

// The only event that it looks for: the client is gone.
Session::Step Session::advance(Deferred& /*state*/) { return Step::over; }

Session::Step Session::advance(Lingering& /*state*/) { return connection_.drop_arrived() ? Step::waits : Step::over; }

Session::Step Session::overdue() {
  if (waits_for_response()) {
    if (auto* const deferred = std::get_if<Deferred>(&state_)) deferred->last_poll = true;
    return Step::ready;
  }
  auto* const reading = std::get_if<ReadingHead>(&state_);
  if (reading != nullptr && connection_.wait_for_taking()) return Step::waits;
  if (lingers() && connection_.is_still_taking()) return Step::waits;
  auto error = reading != nullptr ? connection_.head_overdue() : std::nullopt;
  if (!error) {
    // Nobody waits for what it has not taken by now, in the buffers of the kernel least of all.
    if (connection_.queued() > 0) connection_.give_up();
    return Step::over;
  }
  reading->head = Result<std::string>(std::move(*error));
  return Step::ready;
}

Session::Step Session::handshake() {
  using Progress = TlsChannel::Handshake;
  const Progress progress = connection_.handshake();
  std::get<Handshake>(state_).writes = progress == Progress::writes;
  if (progress == Progress::reads || progress == Progress::writes) return Step::waits;
  if (progress != Progress::done) {
    log(LogLevel::debug, "a TLS handshake failed",
        {{"client", connection_.remote_address()}, {"detail", connection_.handshake_failure()}});
    // Closed with something unread, the socket would take the answer back.
    return progress == Progress::plain ? linger() : Step::over;
  }
  state_ = ReadingHead{};
  // The head often comes in the client's last bytes of the handshake.
  return advance();
}

Session::Step Session::work(Engine& engine, const std::function<void(std::uint64_t)>& wake, bool stopping) {
  if (std::holds_alternative<Handshake>(state_)) return handshake();
  if (std::holds_alternative<Streaming>(state_)) return begin_chunk(wake, stopping);
  if (std::holds_alternative<Deferred>(state_)) return poll(engine, stopping);
  return answer_head(engine, wake, stopping);
}

std::function<void()> Session::waker(const std::function<void(std::uint64_t)>& wake) const {
  return [wake, id = id_, woken = woken_] {
    woken->store(true);
    wake(id);
  };
}

Session::Step Session::answer_head(Engine& engine, const std::function<void(std::uint64_t)>& wake, bool stopping) {
  const Result<std::string> text = *std::exchange(std::get<ReadingHead>(state_).head, std::nullopt);
  auto head = text ? parse_head(*text) : Result<RequestHead>(text.error());
  if (head && (--requests_left_ == 0 || stopping)) head->close = true;
  exchange_ = engine.exchange(connection_, head);
  if (!exchange_.deferred) return begin_writing();
  auto response = exchange_.deferred;
  auto subscription = response->subscribe(waker(wake));
  state_ = Deferred{std::move(response), false, std::move(subscription)};
  return poll(engine, stopping);
}

Session::Step Session::poll(Engine& engine, bool stopping) {
  auto& state = std::get<Deferred>(state_);
  woken_->store(false);
  const bool last = state.last_poll || stopping || Clock::now() >= state.response->deadline;
  std::optional<Response> response = state.response->poll(last);
  if (!response) return Step::waits;
  state.subscription.reset();
  if (stopping && exchange_.after == After::keep) exchange_.after = After::close;
  engine.finish(exchange_, std::move(*response));
  return begin_writing();
}

Unsent::Share Session::share() const {
  const std::uint64_t queued = connection_.queued();
  std::uint64_t here = 0;
  if (const auto* const writing = std::get_if<Writing>(&state_)) here = exchange_.bytes.size() - writing->sent;
  if (const auto* const streaming = std::get_if<Streaming>(&state_)) here = streaming->chunk.size() - streaming->sent;
  return {here, queued, connection_.handed_over() - queued};
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
  state_ = Writing{};
  answered_ = true;
  // The client's pace counts anew: what the handler took (it may have waited for a job) is not its time.
  connection_.begin_transfer();
  return advance();
}

std::optional<Session::Step> Session::send(std::string_view bytes, std::size_t& sent) {
  while (sent < bytes.size()) {
    const auto count = connection_.try_send(bytes.data() + sent, std::min(kSendBytes, bytes.size() - sent));
    if (count < 0) return Step::over;
    if (count == 0) return Step::waits;
    sent += static_cast<std::size_t>(count);
  }
  return std::nullopt;
}

Session::Step Session::advance(Writing& state) {
  if (const auto stopped = send(exchange_.bytes, state.sent)) return *stopped;
  if (!exchange_.stream) return after_writing();
  thread_local std::vector<std::byte> buffer(kSendBytes);
  for (std::uint64_t turn = 0; state.streamed < exchange_.stream->length; turn += buffer.size()) {
    if (turn >= kTurnBytes) return Step::waits;
    const auto wanted = std::min<std::uint64_t>(buffer.size(), exchange_.stream->length - state.streamed);
    const auto read = exchange_.stream->read(state.streamed, std::span(buffer).first(wanted));
    // The head is sent, so a failure can only be shown by breaking off.
    if (!read || *read == 0) return Step::over;
    const auto count = connection_.try_send(reinterpret_cast<const char*>(buffer.data()), *read);
    if (count < 0) return Step::over;
    state.streamed += static_cast<std::uint64_t>(count);
    if (static_cast<std::size_t>(count) < *read) return Step::waits;
  }
  return after_writing();
}

Session::Step Session::begin_chunk(const std::function<void(std::uint64_t)>& wake, bool stopping) {
  auto& state = std::get<Streaming>(state_);
  // It may be woken by the subscription itself, which the first chunk begins.
  if (!state.subscription) state.subscription = state.response->subscribe(waker(wake));
  woken_->store(false);
  StreamingResponse::Chunk chunk = state.response->next(stopping);
  state.ended = chunk.end || stopping;
  if (chunk.more) woken_->store(true);
  state.chunk = std::move(chunk.bytes);
  state.sent = 0;
  state.next_chunk.reset();
  connection_.begin_transfer();
  return advance(state);
}

Session::Step Session::advance(Streaming& state) {
  // As with Deferred: the client is gone.
  if (state.next_chunk) return Step::over;
  if (const auto stopped = send(state.chunk, state.sent)) return *stopped;
  return await_chunk();
}

Session::Step Session::await_chunk() {
  auto& state = std::get<Streaming>(state_);
  state.chunk = {};
  state.sent = 0;
  if (state.ended) return end();
  state.next_chunk = Clock::now() + state.response->interval;
  // The first chunk is there at once, and so is what it was woken for while something was written.
  return !state.subscription || woken() ? Step::ready : Step::waits;
}

Session::Step Session::end() {
  if (connection_.queued() == 0) return Step::over;
  state_ = Lingering{};
  connection_.begin_last_taking();
  return advance();
}

Session::Step Session::linger() {
  state_ = Lingering{};
  connection_.begin_linger();
  return advance();
}

Session::Step Session::after_writing() {
  exchange_.bytes = {};
  if (exchange_.streaming) {
    state_ = Streaming{exchange_.streaming};
    return await_chunk();
  }
  exchange_.stream.reset();
  if (exchange_.after == After::close) return end();
  if (exchange_.after == After::drain) return linger();
  state_ = ReadingHead{};
  connection_.expect_head();
  return advance();
}

}  // namespace surfaced::http
