// SPDX-License-Identifier: GPL-3.0-or-later
// Requests and responses as the handlers see them. Nothing here knows the library that speaks HTTP.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/base.hpp"

namespace surfaced::http {

/// Header fields in their order; names compare without case.
class Headers {
 public:
  void add(std::string name, std::string value) { fields_.emplace_back(std::move(name), std::move(value)); }
  /// In place of what fields of this name there are.
  void set(std::string name, std::string value);
  /// The first field of this name.
  std::optional<std::string_view> find(std::string_view name) const;
  std::size_t count(std::string_view name) const;
  auto begin() const { return fields_.begin(); }
  auto end() const { return fields_.end(); }

 private:
  std::vector<std::pair<std::string, std::string>> fields_;
};

/// True if the two names of header fields are the same.
bool same_name(std::string_view a, std::string_view b);
/// The order of names, without case.
bool comes_before(std::string_view a, std::string_view b);

/// The body of a request, read once and in pieces; never held in memory as a whole.
class BodySource {
 public:
  using Sink = std::function<Status(std::span<const std::byte>)>;

  BodySource() = default;
  BodySource(const BodySource&) = delete;
  BodySource& operator=(const BodySource&) = delete;
  virtual ~BodySource() = default;

  /// False if the request says that it has no body.
  virtual bool present() const = 0;
  /// Its length, if the request gives it.
  virtual std::optional<std::uint64_t> length() const = 0;
  /// Hands the body to the sink piece by piece. Ends with the sink's error, payload_too_large,
  /// request_timeout, or invalid_request if the client breaks off or breaks the rules.
  virtual Status read(const Sink& sink) = 0;
};

using Query = std::vector<std::pair<std::string, std::string>>;

/// Who sends a request, as the filter of the router has found out.
struct Caller {
  /// Id of the key; empty if the server has no keys.
  std::string id;
  /// Sees what belongs to others.
  bool all = true;
  /// Jobs that may wait or run, and bytes that may be stored, for the key; 0: no limit.
  std::uint64_t most_active_jobs = 0;
  std::uint64_t most_stored_bytes = 0;

  /// The owner whose things the caller may see; none for everybody's.
  std::optional<std::string> owner() const { return all ? std::nullopt : std::optional(id); }
};

struct Request {
  std::string method;
  /// As it was sent, without the query.
  std::string path;
  /// Decoded, in its order.
  Query query;
  Headers headers;
  /// Decoded parts of the path, by their names in the route.
  std::map<std::string, std::string, std::less<>> path_parts;
  std::string remote_address;
  std::string request_id;
  Caller caller;
  /// Pattern of the route that was taken; empty if there is none.
  std::string route;
  /// Gone once the handler has returned.
  BodySource* body = nullptr;
};

/// A body of known length that is read while it is sent.
struct BodyStream {
  std::uint64_t length = 0;
  std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::byte> buffer)> read;
};

struct DeferredResponse;
struct StreamingResponse;

struct Response {
  int status = 200;
  Headers headers;
  std::string content_type;
  std::variant<std::string, BodyStream> body;
  /// Set if the answer is not known yet: then nothing else here counts.
  std::shared_ptr<const DeferredResponse> deferred;
  /// Set if the body comes bit by bit, and its end with that of the connection; `body` is then empty.
  std::shared_ptr<const StreamingResponse> streaming;
};

/// A body without a known length, of which the client gets each piece as soon as it is there. The request holds no
/// thread between two pieces.
struct StreamingResponse {
  struct Chunk {
    std::string bytes;
    /// There is more already.
    bool more = false;
    /// Nothing follows.
    bool end = false;
  };
  /// `next` is called at least this often.
  std::chrono::milliseconds interval{15'000};
  /// As in DeferredResponse.
  std::function<std::shared_ptr<void>(std::function<void()> wake)> subscribe;
  /// What is to be sent now. Called once at the beginning, after every wake and every interval, and, with `last`, when
  /// the server stops. Never by two threads at once.
  std::function<Chunk(bool last)> next;
};

/// An answer that is waited for. The request holds no thread meanwhile.
struct DeferredResponse {
  std::chrono::steady_clock::time_point deadline;
  /// From now on calls the function, on any thread, whenever the answer may have become known, until the returned
  /// object is gone. The function returns at once and takes no lock of the caller's.
  std::function<std::shared_ptr<void>(std::function<void()> wake)> subscribe;
  /// The answer, if it is known. Called after `subscribe`, after every wake, and, with `last`, at the deadline
  /// or when the server stops: then it answers in any case.
  std::function<std::optional<Response>(bool last)> poll;
};

}  // namespace surfaced::http
