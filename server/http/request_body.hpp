// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "http/body_decoder.hpp"
#include "http/chunk_guard.hpp"
#include "http/connection.hpp"
#include "http/message.hpp"
#include "http/permits.hpp"
#include "http/request_head.hpp"

namespace surfaced::http {

/// The body of the request that is being answered: read from the connection at a minimum pace and with a permit, up to
/// its end and no byte further, decoded, and counted against the limit.
class RequestBody final : public BodySource {
 public:
  struct Rules {
    const BodyDecoder& decoder;
    /// Decoded bytes.
    std::uint64_t limit;
    Permits& permits;
  };
  /// @param client  whose body it is; found out before the body is read
  RequestBody(Connection& connection, const RequestHead& head, const Rules& rules, const std::string& client);

  bool present() const override { return !std::holds_alternative<NoBody>(head_.framing); }
  std::optional<std::uint64_t> length() const override;
  Status read(const Sink& sink) override;

  /// Nothing of it is left in the connection.
  bool complete() const { return chunked_ ? chunks_.complete() : left_ == 0; }

 private:
  /// Raw bytes, checked.
  std::ptrdiff_t receive(char* bytes, std::size_t size);
  Status decode(const Sink& sink);
  Error too_large(const std::string& what) const;

  Connection& connection_;
  const RequestHead& head_;
  const Rules rules_;
  const std::string& client_;
  const bool chunked_;
  std::uint64_t left_ = 0;
  ChunkGuard chunks_;
  bool broken_ = false;
};

}  // namespace surfaced::http
