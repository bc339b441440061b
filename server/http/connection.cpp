// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/connection.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "http/problem.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

constexpr std::string_view kHeadEnd = "\r\n\r\n";
constexpr std::size_t kReadBytes = 16384;
/// What is taken and dropped before a close.
constexpr std::chrono::milliseconds kLingerTime{2000};
constexpr std::chrono::milliseconds kFirstLook{20};
constexpr std::chrono::milliseconds kLongestLook{1000};
constexpr std::uint64_t kLingerBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kTurnBytes = std::uint64_t{1} << 20;
constexpr int kMostNotSent = 16 << 10;

}  // namespace

Connection::Connection(UniqueFd fd, const ConnectionLimits& limits, const Tls* tls)
    // A new connection is expected to speak; a used one may stay silent for a while.
    : fd_(std::move(fd)), limits_(limits), head_deadline_(Clock::now() + limits.head_time) {
  const int on = 1;
  // Answers are written head first, body after: without this the body waits for an acknowledgement.
  ::setsockopt(fd_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  // The kernel takes no more than this beyond what is on its way, so that a client that takes nothing holds little.
  ::setsockopt(fd_.get(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMostNotSent, sizeof kMostNotSent);
  if (tls != nullptr) tls_.emplace(*tls, fd_.get());
}

bool Connection::has_news() const {
  char byte = 0;
  const ssize_t count = ::recv(fd_.get(), &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return count >= 0 || (errno != EAGAIN && errno != EINTR);
}

TlsChannel::Handshake Connection::handshake() {
  const TlsChannel::Handshake progress = tls_->handshake();
  if (progress == TlsChannel::Handshake::plain) {
    const std::string answer = closing_answer(
        {ErrorCode::invalid_request, "this port speaks HTTPS; the request came without TLS"}, random_hex<12>());
    [[maybe_unused]] const ssize_t sent = ::send(fd_.get(), answer.data(), answer.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  return progress;
}

bool Connection::wait(short events, Clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd descriptor{fd_.get(), events, 0};
    const int count = ::poll(&descriptor, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3'600'000)));
    if (count > 0) return true;
    if (count == 0 && Clock::now() >= deadline) {
      too_slow_ = true;
      return false;
    }
    if (count < 0 && errno != EINTR) return false;
  }
}

std::ptrdiff_t Connection::fill() {
  buffer_.erase(0, used_);
  used_ = 0;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): written before it is read; clearing it costs more than recv
  std::array<char, kReadBytes> bytes;
  for (;;) {
    const std::ptrdiff_t count =
        tls_ ? tls_->receive(bytes.data(), bytes.size()) : ::recv(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && !tls_ && errno == EINTR) continue;
    if (count < 0) return tls_ || errno == EAGAIN ? -1 : 0;
    buffer_.append(bytes.data(), static_cast<std::size_t>(count));
    return count;
  }
}

std::optional<Error> Connection::head_too_large() const {
  const std::string_view unread = std::string_view(buffer_).substr(used_);
  if (std::min(unread.find("\r\n"), unread.size()) > limits_.request_line_bytes) {
    return Error{ErrorCode::uri_too_long,
                 "the request line is longer than " + std::to_string(limits_.request_line_bytes) + " bytes"};
  }
  if (std::min(unread.find(kHeadEnd, searched_), unread.size()) > limits_.head_bytes) {
    return Error{ErrorCode::headers_too_large,
                 "request line and headers are longer than " + std::to_string(limits_.head_bytes) + " bytes"};
  }
  return std::nullopt;
}

Connection::Arrival Connection::take_head() {
  for (;;) {
    const std::string_view unread = std::string_view(buffer_).substr(used_);
    if (!unread.empty() && !head_begun_) {
      head_begun_ = true;
      head_deadline_ = Clock::now() + limits_.head_time;
    }
    if (auto error = head_too_large()) return Result<std::string>(std::move(*error));
    const std::size_t end = unread.find(kHeadEnd, searched_);
    if (end != unread.npos) {
      std::string head(unread.substr(0, end + kHeadEnd.size()));
      used_ += head.size();
      return Result<std::string>(std::move(head));
    }
    searched_ = unread.size() < kHeadEnd.size() ? 0 : unread.size() - kHeadEnd.size() + 1;
    const std::ptrdiff_t count = fill();
    if (count == 0) return Closed{};
    if (count < 0) return Incomplete{};
  }
}

std::optional<Error> Connection::head_overdue() const {
  if (!head_begun_) return std::nullopt;
  return Error{ErrorCode::request_timeout,
               "the headers did not arrive within " + std::to_string(limits_.head_time.count()) + " ms"};
}

void Connection::expect_head() {
  too_slow_ = false;
  head_begun_ = false;
  waited_for_taking_ = false;
  searched_ = 0;
  head_deadline_ = Clock::now() + limits_.idle_time;
}

bool Connection::wait_for_taking() {
  if (head_begun_ || waited_for_taking_ || queued() == 0) return false;
  waited_for_taking_ = true;
  head_deadline_ = Clock::now() + limits_.body_grace;
  return true;
}

void Connection::begin_transfer() {
  transfer_began_ = Clock::now();
  transferred_ = 0;
  too_slow_ = false;
}

Connection::Clock::time_point Connection::transfer_deadline() const {
  return transfer_began_ + limits_.body_grace + std::chrono::milliseconds(transferred_ * 1000 / limits_.body_rate);
}

std::ptrdiff_t Connection::read(char* bytes, std::size_t size) {
  while (used_ == buffer_.size()) {
    const std::ptrdiff_t count = fill();
    if (count == 0) return 0;
    if (count < 0 && !wait(POLLIN, transfer_deadline())) return too_slow_ ? -1 : 0;
  }
  const std::size_t count = std::min(size, buffered());
  std::memcpy(bytes, buffer_.data() + used_, count);
  used_ += count;
  transferred_ += count;
  return static_cast<std::ptrdiff_t>(count);
}

void Connection::note_sent(std::ptrdiff_t count) {
  transferred_ += static_cast<std::uint64_t>(count);
  handed_over_ += static_cast<std::uint64_t>(count);
}

std::ptrdiff_t Connection::try_send(const char* bytes, std::size_t size) {
  if (tls_) {
    const std::ptrdiff_t count = tls_->send(bytes, size);
    if (count > 0) note_sent(count);
    return count;
  }
  for (;;) {
    const ssize_t count = ::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno == EAGAIN ? 0 : -1;
    note_sent(count);
    return count;
  }
}

std::uint64_t Connection::queued() const {
  int bytes = 0;
  return ::ioctl(fd_.get(), SIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::uint64_t>(bytes) : 0;
}

void Connection::give_up() const {
  const linger at_once{1, 0};
  ::setsockopt(fd_.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

bool Connection::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::ptrdiff_t count = try_send(bytes.data(), bytes.size());
    if (count < 0 || (count == 0 && !wait(POLLOUT, transfer_deadline()))) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

void Connection::begin_linger() {
  if (tls_) tls_->end();
  ::shutdown(fd_.get(), SHUT_WR);
  linger_deadline_ = Clock::now() + kLingerTime;
}

void Connection::begin_last_taking() {
  begin_linger();
  taking_deadline_ = Clock::now() + limits_.body_grace;
  until_look_ = kFirstLook;
  linger_deadline_ = Clock::now() + until_look_;
}

bool Connection::is_still_taking() {
  const auto time = Clock::now();
  if (time >= taking_deadline_ || queued() == 0) return false;
  until_look_ = std::min(2 * until_look_, kLongestLook);
  linger_deadline_ = std::min(taking_deadline_, time + until_look_);
  return true;
}

bool Connection::drop_arrived() {
  std::array<char, kReadBytes> bytes{};
  // Others have their turn in between.
  const std::uint64_t turn = dropped_ + kTurnBytes;
  while (dropped_ < kLingerBytes) {
    if (dropped_ >= turn) return true;
    const ssize_t count = ::recv(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count < 0 && errno == EAGAIN;
    dropped_ += static_cast<std::uint64_t>(count);
  }
  return false;
}

std::string Connection::remote_address() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (::getpeername(fd_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  const void* const number = address.ss_family == AF_INET6
                                 ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in6*>(&address)->sin6_addr)
                                 : static_cast<const void*>(&reinterpret_cast<const sockaddr_in*>(&address)->sin_addr);
  const char* const written = ::inet_ntop(address.ss_family, number, text.data(), text.size());
  return written == nullptr ? std::string() : std::string(written);
}

}  // namespace surfaced::http
