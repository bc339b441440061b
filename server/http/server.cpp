// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/server.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <exception>

#include "observability/log.hpp"
#include "platform/files.hpp"

namespace surfaced::http {
namespace {

constexpr int kBacklog = 511;

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

Error cannot_listen(const Address& address, std::string_view why) {
  return {ErrorCode::invalid_usage, "--listen " + address.host + ":" + std::to_string(address.port) +
                                        ": cannot listen there: " + std::string(why)};
}

/// The reason, and what to do about it.
std::string remedied(int error) {
  switch (error) {
    case EADDRINUSE:
      return error_text(error) + "; stop what listens there, or give another port (0 takes a free one)";
    case EADDRNOTAVAIL:
      return error_text(error) + "; this machine has no such address (0.0.0.0 and [::] are all that it has)";
    case EACCES:
      return error_text(error) + "; take a port above 1023, or give the process CAP_NET_BIND_SERVICE";
    default:
      return error_text(error);
  }
}

Result<UniqueFd> bind_to(const addrinfo& where, const Address& address) {
  UniqueFd fd(::socket(where.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return cannot_listen(address, error_text(errno));
  const int on = 1;
  // Not SO_REUSEPORT: that would let a second server take half of the connections in silence.
  ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd.get(), where.ai_addr, where.ai_addrlen) != 0 || ::listen(fd.get(), kBacklog) != 0) {
    return cannot_listen(address, remedied(errno));
  }
  return fd;
}

}  // namespace

Result<Address> parse_address(std::string_view text) {
  const Error wrong{ErrorCode::invalid_usage, "--listen " + std::string(text) +
                                                  ": expected host:port or [IPv6]:port with a port from 0 to 65535"};
  const std::size_t colon = text.rfind(':');
  if (colon == text.npos) return wrong;
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != host.npos) {
    return wrong;
  }
  Address address{std::string(host), 0};
  const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
  if (failed != std::errc() || end != digits.data() + digits.size() || host.empty()) return wrong;
  return address;
}

Result<std::unique_ptr<Server>> Server::listen(const Address& address, const ServerLimits& limits, const Router& router,
                                               Observer observer, const Tls* tls) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int failed = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &list);
  if (failed != 0) return cannot_listen(address, ::gai_strerror(failed));
  const std::unique_ptr<addrinfo, FreeAddresses> found(list);
  auto bound = bind_to(*list, address);
  if (!bound) return bound.error();
  return std::unique_ptr<Server>(new Server(std::move(*bound), limits, router, std::move(observer), tls));
}

Server::Server(UniqueFd listener, const ServerLimits& limits, const Router& router, Observer observer, const Tls* tls)
    : limits_(limits),
      observer_(std::move(observer)),
      tls_(tls),
      permits_("bodies are being received", limits.bodies, limits.bodies_per_address),
      engine_(router, limits.body_bytes, permits_),
      listener_(std::move(listener)),
      loop_(listener_.get(), {limits.connection, limits.connections, limits.requests, limits.unsent, tls},
            [this](std::unique_ptr<Session> session) { add(std::move(session)); }) {}

Server::~Server() { stop(std::chrono::milliseconds(0)); }

std::string Server::url() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::getsockname(listener_.get(), generic, &size) != 0 ||
      ::getnameinfo(generic, size, host.data(), host.size(), port.data(), port.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {};
  }
  const bool v6 = address.ss_family == AF_INET6;
  return std::string(tls_ != nullptr ? "https://" : "http://") + (v6 ? "[" : "") + host.data() + (v6 ? "]:" : ":") +
         port.data();
}

void Server::start() {
  loop_.start();
  for (std::size_t i = 0; i < limits_.threads; ++i) pool_.emplace_back([this] { pool_loop(); });
}

void Server::add(std::unique_ptr<Session> session) {
  const std::scoped_lock lock(mutex_);
  if (ended_) return;
  auto& queue = session->waits_for_chunk() ? streaming_ : ready_;
  queue.push_back(std::move(session));
  work_.notify_one();
}

std::unique_ptr<Session> Server::take_ready() {
  // Requests first, but streams have one turn in four however many there are.
  constexpr unsigned kTurns = 4;
  const bool streams = ready_.empty() || (!streaming_.empty() && ++taken_ % kTurns == 0);
  auto& queue = streams ? streaming_ : ready_;
  std::unique_ptr<Session> session = std::move(queue.front());
  queue.pop_front();
  return session;
}

std::unique_ptr<Session> Server::next() {
  std::unique_lock lock(mutex_);
  work_.wait(lock, [&] { return ended_ || !ready_.empty() || !streaming_.empty(); });
  if (ended_) return nullptr;
  std::unique_ptr<Session> session = take_ready();
  busy_.emplace(session->id(), session->descriptor());
  return session;
}

void Server::pool_loop() {
  while (std::unique_ptr<Session> session = next()) {
    const std::uint64_t id = session->id();
    try {
      work_on(std::move(session));
    } catch (const std::exception& failure) {
      // Memory ran out outside of a handler: this connection ends, the others go on.
      log(LogLevel::error, "a connection failed", {{"detail", failure.what()}});
    }
    const std::scoped_lock lock(mutex_);
    busy_.erase(id);
    idle_.notify_all();
  }
}

void Server::work_on(std::unique_ptr<Session> session) {
  const auto wake = [this](std::uint64_t id) { loop_.wake(id); };
  Session::Step step = session->work(engine_, wake, stopping_);
  if (observer_) {
    if (const auto answered = session->take_answered()) observer_(*answered);
  }
  if (step == Session::Step::waits) {
    loop_.add(std::move(session));
  } else if (step == Session::Step::ready) {
    // The next request of this client waits behind those of others.
    add(std::move(session));
  }
}

void Server::stop(std::chrono::milliseconds grace) {
  if (stopping_.exchange(true)) return;
  loop_.close();
  {
    std::unique_lock lock(mutex_);
    const auto deadline = std::chrono::steady_clock::now() + grace;
    // Connections end on several ways, not all of which pass here.
    constexpr std::chrono::milliseconds kLook{5};
    while (loop_.connections() > 0 && std::chrono::steady_clock::now() < deadline) idle_.wait_for(lock, kLook);
    ended_ = true;
    ready_.clear();
    streaming_.clear();
    for (const auto& [id, descriptor] : busy_) ::shutdown(descriptor, SHUT_RDWR);
    work_.notify_all();
  }
  for (std::thread& thread : pool_) thread.join();
  pool_.clear();
  loop_.stop();
  listener_.reset();
}

}  // namespace surfaced::http
