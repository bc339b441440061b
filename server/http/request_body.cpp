// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/request_body.hpp"

#include <algorithm>
#include <span>

namespace surfaced::http {
namespace {

/// Hands bytes on in pieces of some size: whoever takes them (a form, a file, a hash) has work for every piece, and a
/// client may send chunks of one byte.
class Pieces {
 public:
  explicit Pieces(const BodySource::Sink& sink) : sink_(sink) {}

  Status add(std::string_view bytes) {
    if (kept_.empty() && bytes.size() >= kEnough) return sink_(std::as_bytes(std::span(bytes)));
    kept_.append(bytes);
    return kept_.size() >= kEnough ? flush() : Status(Done{});
  }
  Status flush() {
    if (kept_.empty()) return Done{};
    Status taken = sink_(std::as_bytes(std::span(kept_)));
    kept_.clear();
    return taken;
  }

 private:
  static constexpr std::size_t kEnough = std::size_t{16} << 10;
  const BodySource::Sink& sink_;
  std::string kept_;
};

}  // namespace

RequestBody::RequestBody(Connection& connection, const RequestHead& head, const Rules& rules, const std::string& client)
    : connection_(connection),
      head_(head),
      rules_(rules),
      client_(client),
      chunked_(std::holds_alternative<ChunkedBody>(head.framing)),
      left_(length().value_or(0)) {}

std::optional<std::uint64_t> RequestBody::length() const {
  const auto* length = std::get_if<LengthBody>(&head_.framing);
  return length == nullptr ? std::nullopt : std::optional(length->bytes);
}

std::ptrdiff_t RequestBody::receive(char* bytes, std::size_t size) {
  if (broken_) return -1;
  if (complete()) return 0;
  if (!chunked_) size = std::min<std::uint64_t>(size, left_);
  const std::ptrdiff_t count = connection_.read(bytes, size);
  if (count <= 0) return -1;
  if (chunked_) {
    broken_ = !chunks_.accept({bytes, static_cast<std::size_t>(count)});
  } else {
    left_ -= static_cast<std::uint64_t>(count);
  }
  return broken_ ? -1 : count;
}

Error RequestBody::too_large(const std::string& what) const {
  return {ErrorCode::payload_too_large, what + ", the limit is " + std::to_string(rules_.limit) + " bytes"};
}

Status RequestBody::read(const Sink& sink) {
  if (length().value_or(0) > rules_.limit) return too_large("Content-Length is " + std::to_string(*length()));
  if (!present()) return Done{};
  // What is here already takes nobody's time.
  std::optional<Result<Permits::Permit>> permit;
  if (!length() || *length() > connection_.buffered()) permit.emplace(rules_.permits.acquire(client_));
  if (permit && !permit->ok()) return permit->error();
  connection_.begin_transfer();
  if (head_.expects_continue && !connection_.write("HTTP/1.1 100 Continue\r\n\r\n")) {
    return Error{ErrorCode::request_timeout, "the client did not take the invitation to send its body"};
  }
  return decode(sink);
}

Status RequestBody::decode(const Sink& sink) {
  Status result = Done{};
  std::uint64_t total = 0;
  Pieces pieces(sink);
  const bool read = rules_.decoder.decode(
      head_.framing, [this](char* bytes, std::size_t size) { return receive(bytes, size); },
      [&](std::string_view bytes) {
        total += bytes.size();
        result = total > rules_.limit
                     ? Status(too_large("the body goes on after " + std::to_string(rules_.limit) + " bytes"))
                     : pieces.add(bytes);
        return result.ok();
      });
  // Of a body that breaks off, too: an upload keeps what came.
  if (result) result = pieces.flush();
  if (!result) return result;
  if (read && complete()) return Done{};
  if (connection_.too_slow()) {
    return Error{ErrorCode::request_timeout, "the body came too slowly; " + std::to_string(total) + " bytes arrived"};
  }
  return Error{ErrorCode::invalid_request,
               broken_ ? "the chunks of the body break the rules of HTTP"
                       : "the body ended after " + std::to_string(total) + " bytes, before its end"};
}

}  // namespace surfaced::http
