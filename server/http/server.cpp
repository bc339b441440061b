#include "http/server.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <exception>
#include <iostream>

#include "http/problem.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

constexpr int kBacklog = 511;
/// When descriptors run out, accepting again at once would only spin.
constexpr std::chrono::milliseconds kPauseWithoutDescriptors{50};

struct FreeAddresses {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

Error cannot_listen(const Address& address, std::string_view why) {
  return {ErrorCode::invalid_usage, "--listen " + address.host + ":" + std::to_string(address.port) +
                                        ": cannot listen there: " + std::string(why)};
}

Result<UniqueFd> bind_to(const addrinfo& where, const Address& address) {
  UniqueFd fd(::socket(where.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return cannot_listen(address, error_text(errno));
  const int on = 1;
  // Not SO_REUSEPORT: that would let a second server take half of the connections in silence.
  ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd.get(), where.ai_addr, where.ai_addrlen) != 0 || ::listen(fd.get(), kBacklog) != 0) {
    return cannot_listen(address, error_text(errno));
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

Result<std::unique_ptr<Server>> Server::listen(const Address& address, const ServerLimits& limits,
                                               const Router& router) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int failed = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &list);
  if (failed != 0) return cannot_listen(address, ::gai_strerror(failed));
  const std::unique_ptr<addrinfo, FreeAddresses> found(list);
  auto bound = bind_to(*list, address);
  if (!bound) return bound.error();
  return std::unique_ptr<Server>(new Server(std::move(*bound), limits, router));
}

Server::Server(UniqueFd listener, const ServerLimits& limits, const Router& router)
    : limits_(limits),
      engine_(router, limits.body_bytes),
      listener_(std::move(listener)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

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
  return std::string("http://") + (v6 ? "[" : "") + host.data() + (v6 ? "]:" : ":") + port.data();
}

void Server::start() {
  acceptor_ = std::thread([this] { accept_loop(); });
  for (std::size_t i = 0; i < limits_.threads; ++i) pool_.emplace_back([this] { pool_loop(); });
}

void Server::accept_loop() {
  while (!stopping_) {
    std::array<pollfd, 2> fds{{{listener_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
    ::poll(fds.data(), fds.size(), -1);
    if (stopping_) return;
    UniqueFd client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (client) {
      take(std::move(client));
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      std::this_thread::sleep_for(kPauseWithoutDescriptors);
    }
  }
}

void Server::take(UniqueFd client) {
  {
    const std::scoped_lock lock(mutex_);
    if (queue_.size() < limits_.waiting) {
      queue_.push_back(std::move(client));
      work_.notify_one();
      return;
    }
  }
  turn_away(std::move(client));
}

void Server::turn_away(UniqueFd client) {
  const Error error{ErrorCode::not_ready, "all connections of the server are taken"};
  const std::string id = random_hex<12>();
  const std::string body = text_of(problem_json(error, {}, id));
  const std::string answer =
      "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/problem+json\r\nContent-Length: " +
      std::to_string(body.size()) + "\r\nConnection: close\r\nRetry-After: 1\r\nX-Request-Id: " + id + "\r\n\r\n" +
      body;
  // What has arrived is taken first, or the close would reset the connection before the answer is read.
  std::array<char, 16384> dropped{};
  while (::recv(client.get(), dropped.data(), dropped.size(), MSG_DONTWAIT) > 0) {
  }
  [[maybe_unused]] const ssize_t sent = ::send(client.get(), answer.data(), answer.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  ::shutdown(client.get(), SHUT_WR);
}

void Server::pool_loop() {
  for (;;) {
    UniqueFd client;
    {
      std::unique_lock lock(mutex_);
      work_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
      if (stopping_) return;
      client = std::move(queue_.front());
      queue_.pop_front();
    }
    const int descriptor = client.get();
    Connection connection(std::move(client), limits_.connection);
    After after = After::close;
    try {
      after = serve(connection);
    } catch (const std::exception& failure) {
      // Memory ran out outside of a handler: this connection ends, the others go on.
      std::cerr << "connection: " << failure.what() << std::endl;
    }
    mark(descriptor, Phase::gone);
    if (after == After::drain && !stopping_) connection.close_after_draining();
  }
}

After Server::serve(Connection& connection) {
  for (std::size_t left = limits_.requests; left > 0; --left) {
    mark(connection.descriptor(), Phase::idle);
    const auto text = connection.read_head();
    if (text && !text->has_value()) return After::close;
    mark(connection.descriptor(), Phase::busy);
    auto head = text ? parse_head(**text) : Result<RequestHead>(text.error());
    if (head && (left == 1 || stopping_)) head->close = true;
    const After after = engine_.exchange(connection, head);
    if (after != After::keep) return after;
  }
  return After::close;
}

void Server::mark(int descriptor, Phase phase) {
  const std::scoped_lock lock(mutex_);
  if (phase == Phase::gone) {
    active_.erase(descriptor);
    idle_.notify_all();
    return;
  }
  active_[descriptor] = phase;
  // Whoever begins to wait after `stop` has looked would wait in vain.
  if (phase == Phase::idle && stopping_) ::shutdown(descriptor, SHUT_RD);
}

void Server::stop(std::chrono::milliseconds grace) {
  {
    const std::scoped_lock lock(mutex_);
    if (stopping_.exchange(true)) return;
    queue_.clear();
    ::eventfd_write(wake_.get(), 1);
    work_.notify_all();
  }
  if (acceptor_.joinable()) acceptor_.join();
  listener_.reset();
  {
    std::unique_lock lock(mutex_);
    for (const auto& [descriptor, phase] : active_) {
      if (phase == Phase::idle) ::shutdown(descriptor, SHUT_RD);
    }
    idle_.wait_for(lock, grace, [&] { return active_.empty(); });
    for (const auto& [descriptor, phase] : active_) ::shutdown(descriptor, SHUT_RDWR);
  }
  for (std::thread& thread : pool_) thread.join();
  pool_.clear();
}

}  // namespace surfaced::http
