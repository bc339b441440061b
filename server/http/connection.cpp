#include "http/connection.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace surfaced::http {
namespace {

constexpr std::size_t kReadBytes = 16384;
/// What is taken and dropped before a close.
constexpr std::chrono::milliseconds kLingerTime{2000};
constexpr std::uint64_t kLingerBytes = std::uint64_t{64} << 20;

}  // namespace

Connection::Connection(UniqueFd fd, const ConnectionLimits& limits) : fd_(std::move(fd)), limits_(limits) {
  const int on = 1;
  // Answers are written head first, body after: without this the body waits for an acknowledgement.
  ::setsockopt(fd_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
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

bool Connection::fill(Clock::time_point deadline) {
  if (used_ > 0) {
    buffer_.erase(0, used_);
    used_ = 0;
  }
  for (;;) {
    const std::size_t size = buffer_.size();
    buffer_.resize(size + kReadBytes);
    const ssize_t count = ::recv(fd_.get(), buffer_.data() + size, kReadBytes, MSG_DONTWAIT);
    buffer_.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count > 0) return true;
    if (count == 0 || (errno != EAGAIN && errno != EINTR) || !wait(POLLIN, deadline)) return false;
  }
}

Result<std::optional<std::string>> Connection::read_head() {
  too_slow_ = false;
  const std::string_view kEnd = "\r\n\r\n";
  // A new connection is expected to speak; a used one may stay silent for a while.
  if (used_ == buffer_.size() && !fill(Clock::now() + (fresh_ ? limits_.head_time : limits_.idle_time))) {
    return std::optional<std::string>();
  }
  fresh_ = false;
  const auto deadline = Clock::now() + limits_.head_time;
  for (std::size_t searched = 0;;) {
    const std::string_view unread = std::string_view(buffer_).substr(used_);
    const std::size_t end = unread.find(kEnd, searched);
    if (std::min(unread.find("\r\n"), unread.size()) > limits_.request_line_bytes) {
      return Error{ErrorCode::uri_too_long,
                   "the request line is longer than " + std::to_string(limits_.request_line_bytes) + " bytes"};
    }
    if (std::min(end, unread.size()) > limits_.head_bytes) {
      return Error{ErrorCode::headers_too_large,
                   "request line and headers are longer than " + std::to_string(limits_.head_bytes) + " bytes"};
    }
    if (end != unread.npos) {
      std::string head(unread.substr(0, end + kEnd.size()));
      used_ += head.size();
      return std::optional(std::move(head));
    }
    searched = unread.size() < kEnd.size() ? 0 : unread.size() - kEnd.size() + 1;
    if (fill(deadline)) continue;
    if (!too_slow_) return std::optional<std::string>();
    return Error{ErrorCode::request_timeout,
                 "the headers did not arrive within " + std::to_string(limits_.head_time.count()) + " ms"};
  }
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
  if (used_ == buffer_.size() && !fill(transfer_deadline())) return too_slow_ ? -1 : 0;
  const std::size_t count = std::min(size, buffer_.size() - used_);
  std::memcpy(bytes, buffer_.data() + used_, count);
  used_ += count;
  transferred_ += count;
  return static_cast<std::ptrdiff_t>(count);
}

std::ptrdiff_t Connection::write(const char* bytes, std::size_t size) {
  for (;;) {
    const ssize_t count = ::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count >= 0) {
      transferred_ += static_cast<std::uint64_t>(count);
      return count;
    }
    if ((errno != EAGAIN && errno != EINTR) || !wait(POLLOUT, transfer_deadline())) return -1;
  }
}

void Connection::close_after_draining() {
  ::shutdown(fd_.get(), SHUT_WR);
  const auto deadline = Clock::now() + kLingerTime;
  std::array<char, kReadBytes> dropped{};
  for (std::uint64_t total = 0; total < kLingerBytes && wait(POLLIN, deadline);) {
    const ssize_t count = ::recv(fd_.get(), dropped.data(), dropped.size(), MSG_DONTWAIT);
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) break;
    total += static_cast<std::uint64_t>(std::max<ssize_t>(count, 0));
  }
  fd_.reset();
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
