#include "http/engine.hpp"

#include <httplib.h>

#include <array>
#include <iostream>
#include <utility>

#include "http/chunk_guard.hpp"
#include "http/problem.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

constexpr std::size_t kSendBytes = std::size_t{64} << 10;

/// What the library reads and writes: first the request that was made for it, then the client's body
/// and no byte beyond it.
class GuardedStream final : public httplib::Stream {
 public:
  GuardedStream(Connection& connection, std::string head, const Framing& framing)
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
    const std::ptrdiff_t count = connection_.read(bytes, size);
    if (count <= 0) return -1;
    if (chunked_) {
      broken_ = !chunks_.accept({bytes, static_cast<std::size_t>(count)});
    } else {
      left_ -= static_cast<std::uint64_t>(count);
    }
    return broken_ ? -1 : count;
  }

  ssize_t write(const char* bytes, std::size_t size) override { return connection_.write(bytes, size); }

  bool body_complete() const { return chunked_ ? chunks_.complete() : left_ == 0; }
  bool broken() const { return broken_; }

 private:
  Connection& connection_;
  std::string head_;
  std::size_t head_read_ = 0;
  bool chunked_;
  std::uint64_t left_ = 0;
  ChunkGuard chunks_;
  bool broken_ = false;
};

/// The body of the request that is being answered.
class GuardedBody final : public BodySource {
 public:
  GuardedBody(Connection& connection, GuardedStream& stream, const RequestHead& head, std::uint64_t limit)
      : connection_(connection), stream_(stream), head_(head), limit_(limit) {}

  bool present() const override { return !std::holds_alternative<NoBody>(head_.framing); }

  std::optional<std::uint64_t> length() const override {
    const auto* length = std::get_if<LengthBody>(&head_.framing);
    return length == nullptr ? std::nullopt : std::optional(length->bytes);
  }

  void use(const httplib::ContentReader* reader) { reader_ = reader; }

  Status read(const Sink& sink) override {
    if (length().value_or(0) > limit_) return too_large("Content-Length is " + std::to_string(*length()));
    if (!present() || reader_ == nullptr) return Done{};
    connection_.begin_transfer();
    if (head_.expects_continue) stream_.httplib::Stream::write("HTTP/1.1 100 Continue\r\n\r\n");
    Status result = Done{};
    std::uint64_t total = 0;
    const bool read = (*reader_)([&](const char* bytes, std::size_t size) {
      total += size;
      result = total > limit_ ? Status(too_large("the body goes on after " + std::to_string(limit_) + " bytes"))
                              : sink(std::as_bytes(std::span(bytes, size)));
      return result.ok();
    });
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
  const httplib::ContentReader* reader_ = nullptr;
};

/// What is being answered on this thread: the library's handlers are given nothing of ours.
struct Exchange {
  const Router& router;
  Connection& connection;
  GuardedStream& stream;
  GuardedBody& body;
  Request request;
  /// Set if the head was refused.
  std::optional<Error> refusal;
  bool close = false;
  /// The request came too slowly.
  bool too_slow = false;
};
thread_local Exchange* current = nullptr;

void copy_body(Response& from, httplib::Response& to) {
  if (auto* text = std::get_if<std::string>(&from.body)) {
    to.body = std::move(*text);
    return;
  }
  auto stream = std::get<BodyStream>(std::move(from.body));
  // The library does not take a provider of nothing.
  if (stream.length == 0) return;
  const auto length = static_cast<std::size_t>(stream.length);
  to.set_content_provider(
      length, from.content_type,
      [read = std::move(stream.read)](std::size_t offset, std::size_t left, httplib::DataSink& sink) {
        std::vector<std::byte> buffer(std::min(left, kSendBytes));
        const auto count = read(offset, buffer);
        // The head is sent, so a failure can only be shown by breaking off.
        if (!count || *count == 0) return false;
        return sink.write(reinterpret_cast<const char*>(buffer.data()), *count);
      });
}

void answer(httplib::Response& to) {
  Exchange& exchange = *current;
  Response response = exchange.refusal ? problem_response(*exchange.refusal, exchange.request)
                                       : exchange.router.handle(exchange.request);
  // The client's pace counts anew: what the handler took (it may have waited for a job) is not its time.
  exchange.too_slow |= exchange.connection.too_slow();
  exchange.connection.begin_transfer();
  to.status = response.status;
  for (const auto& [name, value] : response.headers) to.set_header(name, value);
  to.set_header("X-Request-Id", exchange.request.request_id);
  to.set_header("X-Content-Type-Options", "nosniff");
  copy_body(response, to);
  if (!response.content_type.empty()) {
    to.headers.erase("Content-Type");
    to.set_header("Content-Type", response.content_type);
  }
}

/// Runs after the library has added its own headers, twice.
void finish_headers(httplib::Response& to) {
  to.headers.erase("Keep-Alive");
  to.headers.erase("Connection");
  if (current->close || !current->stream.body_complete()) to.set_header("Connection", "close");
  if (to.status == 304 || to.status == 204) to.headers.erase("Content-Length");
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

}  // namespace

class Engine::Library final : public httplib::Server {
 public:
  Library() {
    // The library takes "no socket" for "shutting down" and would cut answers short.
    svr_sock_ = 0;
    fill_tables();
    Get("/", [](const httplib::Request&, httplib::Response& to) { answer(to); });
    Post("/", [](const httplib::Request&, httplib::Response& to, const httplib::ContentReader& reader) {
      current->body.use(&reader);
      answer(to);
    });
    set_post_routing_handler([](const httplib::Request&, httplib::Response& to) { finish_headers(to); });
    set_exception_handler([](const httplib::Request&, httplib::Response& to, const std::exception_ptr&) {
      // The router lets nothing through; this is for what answer() itself may throw.
      to = httplib::Response();
      to.status = status_of(ErrorCode::internal_error);
    });
  }

  bool run(httplib::Stream& stream) {
    bool closed = false;
    return process_request(stream, false, closed, nullptr);
  }

 private:
  /// The library fills static tables at its first request. That is safe in threads, but the thread
  /// sanitizer cannot see it through a library it has not compiled; so the first request is ours.
  void fill_tables() {
    httplib::detail::BufferStream stream;
    stream.httplib::Stream::write("GET / HTTP/1.1\r\n\r\n");
    run(stream);
  }
};

Engine::Engine(const Router& router, std::uint64_t body_limit)
    : router_(router), body_limit_(body_limit), library_(std::make_unique<Library>()) {}

Engine::~Engine() = default;

After Engine::exchange(Connection& connection, const Result<RequestHead>& head) {
  const RequestHead nothing{"GET", {}, {}, {}, NoBody{}, true, false};
  const RequestHead& shown = head ? *head : nothing;
  GuardedStream stream(connection, head_for_library(shown), shown.framing);
  GuardedBody body(connection, stream, shown, body_limit_);
  Exchange exchange{router_, connection, stream, body, {}, {}, shown.close, connection.too_slow()};
  exchange.request.method = shown.method;
  exchange.request.path = shown.path;
  exchange.request.headers = shown.headers;
  exchange.request.remote_address = connection.remote_address();
  exchange.request.request_id = random_hex<12>();
  exchange.request.body = &body;
  if (auto query = parse_query(shown.query)) {
    exchange.request.query = std::move(*query);
  } else {
    exchange.refusal = query.error();
  }
  if (!head) exchange.refusal = head.error();
  current = &exchange;
  const bool written = library_->run(stream);
  current = nullptr;
  // Who was too slow has nothing on its way that is worth a thread.
  if (!written || exchange.too_slow || connection.too_slow()) return After::close;
  if (!head || !stream.body_complete()) return After::drain;
  return exchange.close ? After::close : After::keep;
}

}  // namespace surfaced::http
