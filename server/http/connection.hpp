#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/base.hpp"
#include "platform/unique_fd.hpp"

namespace surfaced::http {

struct ConnectionLimits {
  /// Request line and header fields together.
  std::size_t head_bytes = 32 << 10;
  std::size_t request_line_bytes = 8 << 10;
  /// From the first byte of a head to its last.
  std::chrono::milliseconds head_time{10'000};
  /// Between two requests.
  std::chrono::milliseconds idle_time{5'000};
  /// How long a body, or a response, may take before its pace counts.
  std::chrono::milliseconds body_grace{30'000};
  /// Bytes a second that a client must keep up with from then on.
  std::uint64_t body_rate = 4096;
};

/// A socket with a buffer, and a deadline for everything that waits for the other side.
class Connection {
 public:
  using Clock = std::chrono::steady_clock;

  Connection(UniqueFd fd, const ConnectionLimits& limits);

  /// The next head, up to and with its empty line; none if the client closed or stayed silent.
  /// Errors: uri_too_long, headers_too_large, request_timeout.
  Result<std::optional<std::string>> read_head();

  /// Reads up to `size` bytes that follow the head; 0 at the end of the stream, -1 when the client is
  /// too slow or gone.
  std::ptrdiff_t read(char* bytes, std::size_t size);

  /// Writes up to `size` bytes; -1 when the client is too slow or gone.
  std::ptrdiff_t write(const char* bytes, std::size_t size);

  /// A body, or a response, begins: its pace counts from now.
  void begin_transfer();
  /// The last read or write failed because the client was too slow.
  bool too_slow() const { return too_slow_; }

  /// Takes what the client still sends, for a short time, so that it sees the answer before the reset.
  void close_after_draining();

  int descriptor() const { return fd_.get(); }
  std::string remote_address() const;

 private:
  bool wait(short events, Clock::time_point deadline);
  /// Reads into the buffer; false at the end, at the deadline or after an error.
  bool fill(Clock::time_point deadline);
  Clock::time_point transfer_deadline() const;

  UniqueFd fd_;
  const ConnectionLimits& limits_;
  std::string buffer_;
  std::size_t used_ = 0;
  Clock::time_point transfer_began_;
  std::uint64_t transferred_ = 0;
  bool too_slow_ = false;
  bool fresh_ = true;
};

}  // namespace surfaced::http
