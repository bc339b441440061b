// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/engine.hpp"

#include <httplib.h>

#include <functional>
#include <utility>

#include "http/chunk_guard.hpp"
#include "http/problem.hpp"
#include "platform/clock.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

/// What the library reads and writes: it reads the request that was made for it, then the client's body and no byte
/// beyond it; what it writes stays in memory.
class GuardedStream final : public httplib::Stream {
 public:
  /// @param connection  where the body comes from; none if there is none
  GuardedStream(Connection* connection, std::string head, const Framing& framing)
      : connection_(connection), head_(std::move(head)), chunked_(std::holds_alternative<ChunkedBody>(framing)) {
    if (const auto* length = std::get_if<LengthBody>(&framing)) left_ = length->bytes;
  }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  // The library refuses descriptors above 1023, which only matter to select().
  socket_t socket() const override { return INVALID_SOCKET; }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}

  ssize_t read(char* bytes, std::size_t size) override {
    if (head_read_ < head_.size()) {
      const std::size_t count = std::min(size, head_.size() - head_read_);
      head_.copy(bytes, count, head_read_);
      head_read_ += count;
      return static_cast<ssize_t>(count);
    }
    if (body_complete() || broken_) return broken_ ? -1 : 0;
    if (!chunked_) size = std::min<std::uint64_t>(size, left_);
    const std::ptrdiff_t count = connection_->read(bytes, size);
    if (count <= 0) return -1;
    if (chunked_) {
      broken_ = !chunks_.accept({bytes, static_cast<std::size_t>(count)});
    } else {
      left_ -= static_cast<std::uint64_t>(count);
    }
    return broken_ ? -1 : count;
  }

  ssize_t write(const char* bytes, std::size_t size) override {
    written_.append(bytes, size);
    return static_cast<ssize_t>(size);
  }

  bool body_complete() const { return chunked_ ? chunks_.complete() : left_ == 0; }
  bool broken() const { return broken_; }
  std::string take_written() { return std::move(written_); }

 private:
  Connection* connection_;
  std::string head_;
  std::string written_;
  std::size_t head_read_ = 0;
  bool chunked_;
  std::uint64_t left_ = 0;
  ChunkGuard chunks_;
  bool broken_ = false;
};

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

/// The body of the request that is being answered.
class GuardedBody final : public BodySource {
 public:
  /// @param client  whose body it is; found out before the body is read
  GuardedBody(Connection& connection, GuardedStream& stream, const RequestHead& head, std::uint64_t limit,
              Places& places, const std::string& client)
      : connection_(connection), stream_(stream), head_(head), limit_(limit), places_(places), client_(client) {}

  bool present() const override { return !std::holds_alternative<NoBody>(head_.framing); }

  std::optional<std::uint64_t> length() const override {
    const auto* length = std::get_if<LengthBody>(&head_.framing);
    return length == nullptr ? std::nullopt : std::optional(length->bytes);
  }

  void use(const httplib::ContentReader* reader) { reader_ = reader; }

  Status read(const Sink& sink) override {
    if (length().value_or(0) > limit_) return too_large("Content-Length is " + std::to_string(*length()));
    if (!present() || reader_ == nullptr) return Done{};
    // What is here already takes nobody's time.
    std::optional<Result<Places::Place>> place;
    if (!length() || *length() > connection_.buffered()) place.emplace(places_.take(client_));
    if (place && !place->ok()) return place->error();
    connection_.begin_transfer();
    if (head_.expects_continue && !connection_.write("HTTP/1.1 100 Continue\r\n\r\n")) {
      return Error{ErrorCode::request_timeout, "the client did not take the invitation to send its body"};
    }
    Status result = Done{};
    std::uint64_t total = 0;
    Pieces pieces(sink);
    const bool read = (*reader_)([&](const char* bytes, std::size_t size) {
      total += size;
      result = total > limit_ ? Status(too_large("the body goes on after " + std::to_string(limit_) + " bytes"))
                              : pieces.add({bytes, size});
      return result.ok();
    });
    // Of a body that breaks off, too: an upload keeps what came.
    if (result) result = pieces.flush();
    if (!result) return result;
    if (read && stream_.body_complete()) return Done{};
    if (connection_.too_slow()) {
      return Error{ErrorCode::request_timeout, "the body came too slowly; " + std::to_string(total) + " bytes arrived"};
    }
    return Error{ErrorCode::invalid_request,
                 stream_.broken() ? "the chunks of the body break the rules of HTTP"
                                  : "the body ended after " + std::to_string(total) + " bytes, before its end"};
  }

 private:
  Error too_large(const std::string& what) const {
    return {ErrorCode::payload_too_large, what + ", the limit is " + std::to_string(limit_) + " bytes"};
  }

  Connection& connection_;
  GuardedStream& stream_;
  const RequestHead& head_;
  const std::uint64_t limit_;
  Places& places_;
  const std::string& client_;
  const httplib::ContentReader* reader_ = nullptr;
};

/// What the library is used for on this thread: its handlers are given nothing of ours.
struct Use {
  Exchange& exchange;
  const GuardedStream& stream;
  /// For reading a request.
  GuardedBody* body = nullptr;
  std::function<Response()> handle;
  Response response{};
  bool close = false;
};
thread_local Use* current = nullptr;

/// Hands the answer to the library, but for streams, of which it only writes the head.
void show(Response& response, httplib::Response& to) {
  Exchange& exchange = current->exchange;
  to.status = response.status;
  for (const auto& [name, value] : response.headers) to.set_header(name, value);
  to.set_header("Date", to_http_date(now()));
  to.set_header("X-Request-Id", exchange.request.request_id);
  to.set_header("X-Content-Type-Options", "nosniff");
  if (auto* text = std::get_if<std::string>(&response.body)) to.body = std::move(*text);
  if (!response.content_type.empty()) to.set_header("Content-Type", response.content_type);
}

void answer(httplib::Response& to) {
  current->response = current->handle();
  if (!current->response.later) show(current->response, to);
}

/// Runs after the library has added its own headers, twice.
void finish_headers(httplib::Response& to) {
  to.headers.erase("Keep-Alive");
  to.headers.erase("Connection");
  if (current->close || !current->stream.body_complete()) to.set_header("Connection", "close");
  if (const auto* stream = std::get_if<BodyStream>(&current->response.body)) {
    to.headers.erase("Content-Length");
    to.set_header("Content-Length", std::to_string(stream->length));
  }
  if (current->response.feed) to.set_header("Connection", "close");
  if (to.status == 304 || to.status == 204 || current->response.feed) to.headers.erase("Content-Length");
}

/// The request as the library sees it: enough to find the body's end and to leave the body of an
/// answer to HEAD away.
std::string head_for_library(const RequestHead& head) {
  std::string text =
      (head.method == "GET" || head.method == "HEAD" ? head.method : std::string("POST")) + " / HTTP/1.1\r\n";
  if (const auto* length = std::get_if<LengthBody>(&head.framing)) {
    text += "Content-Length: " + std::to_string(length->bytes) + "\r\n";
  } else if (std::holds_alternative<ChunkedBody>(head.framing)) {
    text += "Transfer-Encoding: chunked\r\n";
  } else {
    text += "Content-Length: 0\r\n";
  }
  return text + "\r\n";
}

/// Moves what the library wrote, and the stream behind it, into the exchange.
void take_answer(Exchange& exchange, Use& use, GuardedStream& stream) {
  exchange.status = use.response.status;
  exchange.bytes = stream.take_written();
  if (use.response.feed) {
    exchange.after = After::close;
    if (exchange.request.method != "HEAD") exchange.feed = use.response.feed;
  }
  auto* body = std::get_if<BodyStream>(&use.response.body);
  if (body != nullptr && body->length > 0 && exchange.request.method != "HEAD") exchange.stream = std::move(*body);
}

}  // namespace

class Engine::Library final : public httplib::Server {
 public:
  Library() {
    // The library takes "no socket" for "shutting down" and would cut answers short.
    svr_sock_ = 0;
    fill_tables();
    Get("/", [](const httplib::Request&, httplib::Response& to) { answer(to); });
    Post("/", [](const httplib::Request&, httplib::Response& to, const httplib::ContentReader& reader) {
      current->body->use(&reader);
      answer(to);
    });
    set_post_routing_handler([](const httplib::Request&, httplib::Response& to) { finish_headers(to); });
    set_exception_handler([](const httplib::Request&, httplib::Response& to, const std::exception_ptr&) {
      // The router lets nothing through; this is for what answer() itself may throw.
      to = httplib::Response();
      to.status = status_of(ErrorCode::internal_error);
    });
  }

  bool run(Use& use, httplib::Stream& stream) {
    current = &use;
    bool closed = false;
    const bool written = process(*this, stream, closed);
    current = nullptr;
    return written;
  }

 private:
  /// Later versions of the library are told the addresses of both ends, which it only repeats to handlers: ours have
  /// them from the connection.
  template <class Server>
  static bool process(Server& server, httplib::Stream& stream, bool& closed) {
    if constexpr (requires { server.process_request(stream, false, closed, nullptr); }) {
      return server.process_request(stream, false, closed, nullptr);
    } else {
      return server.process_request(stream, {}, 0, {}, 0, false, closed, nullptr);
    }
  }

  /// The library fills static tables at its first request. That is safe in threads, but the thread
  /// sanitizer cannot see it through a library it has not compiled; so the first request is ours.
  void fill_tables() {
    Exchange exchange;
    GuardedStream stream(nullptr, "GET / HTTP/1.1\r\n\r\n", NoBody{});
    Use use{exchange, stream, nullptr, [] { return Response(); }};
    run(use, stream);
  }
};

Engine::Engine(const Router& router, std::uint64_t body_limit, Places& places)
    : router_(router), body_limit_(body_limit), places_(places), library_(std::make_unique<Library>()) {}

Engine::~Engine() = default;

Exchange Engine::exchange(Connection& connection, const Result<RequestHead>& head) {
  const RequestHead nothing{"GET", {}, {}, {}, NoBody{}, true, false};
  const RequestHead& shown = head ? *head : nothing;
  Exchange exchange;
  exchange.began = std::chrono::steady_clock::now();
  GuardedStream stream(&connection, head_for_library(shown), shown.framing);
  Request& request = exchange.request;
  GuardedBody body(connection, stream, shown, body_limit_, places_, request.remote_address);
  request.method = shown.method;
  request.path = shown.path;
  request.headers = shown.headers;
  request.remote_address = connection.remote_address();
  request.request_id = random_hex<12>();
  request.body = &body;
  auto query = parse_query(shown.query);
  Use use{exchange, stream, &body, [&] {
            if (!head) return problem_response(head.error(), request);
            if (!query) return problem_response(query.error(), request);
            request.query = std::move(*query);
            return router_.handle(request);
          }};
  use.close = shown.close;
  const bool understood = library_->run(use, stream);
  request.body = nullptr;
  if (!understood || connection.too_slow()) {
    // Who was too slow has nothing on its way that is worth waiting for.
    exchange.after = After::close;
  } else if (!head || !stream.body_complete()) {
    exchange.after = After::drain;
  } else {
    exchange.after = shown.close ? After::close : After::keep;
  }
  exchange.later = use.response.later;
  if (!exchange.later) take_answer(exchange, use, stream);
  return exchange;
}

void Engine::finish(Exchange& exchange, Response response) {
  GuardedStream stream(
      nullptr, exchange.request.method == "HEAD" ? "HEAD / HTTP/1.1\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n", NoBody{});
  Use use{exchange, stream, nullptr, [&] { return std::move(response); }};
  use.close = exchange.after != After::keep;
  library_->run(use, stream);
  exchange.later.reset();
  take_answer(exchange, use, stream);
}

}  // namespace surfaced::http
