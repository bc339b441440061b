// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/body_decoder.hpp"

#include <httplib.h>

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

namespace surfaced::http {
namespace {

/// What the library reads: the head that was made for it, then the client's body. The answer it writes goes nowhere.
class LibraryStream final : public httplib::Stream {
 public:
  LibraryStream(std::string head, const BodyDecoder::Source& source) : head_(std::move(head)), source_(source) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  // The library refuses descriptors above 1023, which only matter to select().
  socket_t socket() const override { return INVALID_SOCKET; }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}

  ssize_t read(char* bytes, std::size_t size) override {
    if (read_ == head_.size()) return source_(bytes, size);
    const std::size_t count = std::min(size, head_.size() - read_);
    head_.copy(bytes, count, read_);
    read_ += count;
    return static_cast<ssize_t>(count);
  }

  ssize_t write(const char* /*bytes*/, std::size_t size) override { return static_cast<ssize_t>(size); }

 private:
  std::string head_;
  std::size_t read_ = 0;
  const BodyDecoder::Source& source_;
};

/// Enough of a request for the library to find the end of the body.
std::string head_for(const Framing& framing) {
  const auto* const length = std::get_if<LengthBody>(&framing);
  return "POST / HTTP/1.1\r\n" +
         (length != nullptr ? "Content-Length: " + std::to_string(length->bytes) : "Transfer-Encoding: chunked") +
         "\r\n\r\n";
}

/// What is decoded on this thread: the library hands its handlers nothing of ours.
struct Decoding {
  const BodyDecoder::Sink& sink;
  bool complete = false;
  std::exception_ptr failure{};
};
thread_local Decoding* current = nullptr;

void read_all(const httplib::ContentReader& reader) {
  try {
    current->complete = reader([sink = &current->sink](const char* bytes, std::size_t size) {
      return (*sink)({bytes, size});
    });
  } catch (...) {
    // Not through the library, which makes an answer of what it catches.
    current->failure = std::current_exception();
  }
}

}  // namespace

class BodyDecoder::Library final : public httplib::Server {
 public:
  Library() {
    // The library takes "no socket" for "shutting down" and would not begin.
    svr_sock_ = 0;
    Post("/",
         [](const httplib::Request&, httplib::Response&, const httplib::ContentReader& reader) { read_all(reader); });
  }

  void process(httplib::Stream& stream) {
    bool closed = false;
    process(*this, stream, closed);
  }

 private:
  /// Later versions of the library are told the addresses of both ends, which it only repeats to handlers.
  template <class Server>
  static void process(Server& server, httplib::Stream& stream, bool& closed) {
    if constexpr (requires { server.process_request(stream, true, closed, nullptr); }) {
      server.process_request(stream, true, closed, nullptr);
    } else {
      server.process_request(stream, {}, 0, {}, 0, true, closed, nullptr);
    }
  }
};

BodyDecoder::BodyDecoder() : library_(std::make_unique<Library>()) {}

BodyDecoder::~BodyDecoder() = default;

bool BodyDecoder::decode(const Framing& framing, const Source& source, const Sink& sink) const {
  if (std::holds_alternative<NoBody>(framing)) return true;
  LibraryStream stream(head_for(framing), source);
  Decoding decoding{sink};
  Decoding* const before = std::exchange(current, &decoding);
  library_->process(stream);
  current = before;
  if (decoding.failure) std::rethrow_exception(decoding.failure);
  return decoding.complete;
}

}  // namespace surfaced::http

#ifdef __SANITIZE_THREAD__
/// The library fills static tables at its first use. That is safe in threads, but the sanitizer cannot see it through a
/// library that was compiled without it.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the name is the sanitizer's
extern "C" const char* __tsan_default_suppressions() { return "called_from_lib:libcpp-httplib\n"; }
#endif
