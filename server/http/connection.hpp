// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "base/base.hpp"
#include "base/unique_fd.hpp"
#include "http/tls.hpp"

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

/// A socket with a buffer, and TLS in between if the server speaks it. What waits for the client's head is done step by
/// step by whoever has the time (handshake, take_head, try_send, drop_arrived never block); only the body of a request
/// is waited for, at a minimum pace.
class Connection {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param tls  none for plain HTTP
  Connection(UniqueFd fd, const ConnectionLimits& limits, const Tls* tls);

  /// True if the client has sent something, or is gone.
  bool has_news() const;
  /// Goes on with the handshake of TLS; a client that speaks plain HTTP is told that this is the wrong port for it.
  TlsChannel::Handshake handshake();
  /// Why it failed.
  const std::string& handshake_failure() const { return tls_->why(); }

  /// What has arrived of the next head.
  struct Incomplete {};
  /// The client has closed, or is gone.
  struct Closed {};
  using Arrival = std::variant<Incomplete, Closed, Result<std::string>>;
  /// The next head, up to and with its empty line, as soon as it is there.
  /// Errors: uri_too_long, headers_too_large.
  Arrival take_head();

  /// When the client must have sent its next head; later with its first byte.
  Clock::time_point head_deadline() const { return head_deadline_; }
  /// The answer to a head that began and did not end in time; none if it did not begin: then the connection is
  /// closed in silence.
  std::optional<Error> head_overdue() const;
  /// An answer has been written: the next head is waited for from now.
  void expect_head();
  /// The client still has to take what the kernel holds of the answer before, and has `body_grace` for it, once. False
  /// if there is nothing to take, or that time is over.
  bool wait_for_taking();

  /// Reads up to `size` bytes that follow the head; 0 at the end of the stream, -1 when the client is
  /// too slow or gone.
  std::ptrdiff_t read(char* bytes, std::size_t size);
  /// Bytes that follow the head and are here already.
  std::size_t buffered() const { return buffer_.size() - used_; }

  /// Writes all bytes; false when the client is too slow or gone.
  bool write(std::string_view bytes);
  /// Writes what the socket takes now; -1 when the client is gone.
  std::ptrdiff_t try_send(const char* bytes, std::size_t size);

  /// Bytes that the kernel holds for the client: sent and not yet confirmed, or not yet sent.
  std::uint64_t queued() const;
  /// Bytes that have been handed to the kernel, since the connection began.
  std::uint64_t handed_over() const { return handed_over_; }
  /// The close to come is at once: what the client has not taken is thrown away, or the kernel would keep it for
  /// minutes.
  void give_up() const;

  /// A body, or a response, begins: its pace counts from now.
  void begin_transfer();
  /// When the client has to have taken or sent more than it has.
  Clock::time_point transfer_deadline() const;
  /// The last read or write failed because the client was too slow.
  bool too_slow() const { return too_slow_; }

  /// No answer follows; what the client still sends is to be dropped for a while, so that it sees the answer
  /// before the reset.
  void begin_linger();
  /// The same for a client that has sent nothing more, but has not taken all of the answer yet: it has `body_grace`.
  void begin_last_taking();
  /// At the deadline: whether it is still taking, and is looked at again later. The kernel tells nobody that it is
  /// done.
  bool is_still_taking();
  Clock::time_point linger_deadline() const { return linger_deadline_; }
  /// False once nothing more is to be waited for.
  bool drop_arrived();

  int descriptor() const { return fd_.get(); }
  std::string remote_address() const;

 private:
  bool wait(short events, Clock::time_point deadline);
  /// Reads into the buffer what is there: the number of bytes, 0 at the end, -1 if nothing is there now.
  std::ptrdiff_t fill();
  std::optional<Error> head_too_large() const;
  void note_sent(std::ptrdiff_t count);

  UniqueFd fd_;
  // Ends before the descriptor does.
  std::optional<TlsChannel> tls_;
  const ConnectionLimits& limits_;
  std::string buffer_;
  std::size_t used_ = 0;
  // Of the head that is on its way: up to here there is no empty line.
  std::size_t searched_ = 0;
  bool head_begun_ = false;
  bool waited_for_taking_ = false;
  Clock::time_point head_deadline_;
  Clock::time_point transfer_began_;
  Clock::time_point linger_deadline_;
  // Of the last taking: when it has to be over, and how long it is until the next look.
  Clock::time_point taking_deadline_;
  std::chrono::milliseconds until_look_{0};
  std::uint64_t transferred_ = 0;
  std::uint64_t handed_over_ = 0;
  std::uint64_t dropped_ = 0;
  bool too_slow_ = false;
};

}  // namespace surfaced::http
