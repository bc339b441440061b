// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/base.hpp"
#include "base/unique_fd.hpp"
#include "http/connection.hpp"
#include "http/engine.hpp"
#include "http/event_loop.hpp"

namespace surfaced::http {

/// host:port, [IPv6]:port.
struct Address {
  std::string host;
  std::uint16_t port = 0;
};
/// invalid_usage for anything else.
Result<Address> parse_address(std::string_view text);

struct ServerLimits {
  ConnectionLimits connection;
  std::uint64_t body_bytes = std::uint64_t{4} << 30;
  /// Connections at once.
  std::size_t connections = 2000;
  /// Requests that are worked on at once.
  std::size_t threads = 64;
  /// Bodies that are received at once, in all and from one address (0: no limit). Fewer than threads, so that
  /// some are free whatever clients do.
  std::size_t bodies = 48;
  std::size_t bodies_per_address = 0;
  /// Requests on one connection.
  std::size_t requests = 1000;
  /// What clients may leave untaken.
  Unsent::Limits unsent;
};

/// What the server tells of itself.
struct ServerState {
  std::size_t connections = 0;
  /// Connections that were refused, or closed for a new one.
  std::uint64_t turned_away = 0;
  /// Bytes of answers that clients have not taken yet.
  std::uint64_t unsent_bytes = 0;
  /// Clients that were cut off because they took nothing.
  std::uint64_t cut_off = 0;
};

/// Listens, and gives requests to a pool of threads once their head is there (event_loop.hpp). A thread is held while a
/// body arrives, for which there are permits, and while a handler works, which does not wait for anybody.
class Server {
 public:
  /// Told of every request once its answer is known, on the thread that worked on it; must not throw.
  using Observer = std::function<void(const Exchange& answered)>;

  /// Binds and listens; port 0 takes a free one. invalid_usage if the address cannot be had.
  /// @param tls  outlives the server; none for plain HTTP
  static Result<std::unique_ptr<Server>> listen(const Address& address, const ServerLimits& limits,
                                                const Router& router, Observer observer = {}, const Tls* tls = nullptr);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// http://host:port, or https, with the real port.
  std::string url() const;

  void start();

  /// Accepts no more, answers what has arrived and whoever waits for an answer, for this long; then cuts off the rest.
  void stop(std::chrono::milliseconds grace);

  ServerState state() const {
    return {loop_.connections(), loop_.turned_away(), loop_.unsent_bytes(), loop_.cut_off()};
  }

 private:
  Server(UniqueFd listener, const ServerLimits& limits, const Router& router, Observer observer, const Tls* tls);
  void pool_loop();
  std::unique_ptr<Session> next();
  std::unique_ptr<Session> take_ready();
  void work_on(std::unique_ptr<Session> session);
  void add(std::unique_ptr<Session> session);

  const ServerLimits limits_;
  const Observer observer_;
  const Tls* const tls_;
  Permits permits_;
  Engine engine_;
  UniqueFd listener_;
  EventLoop loop_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable idle_;
  /// Both bounded by the number of connections. A crowd that follows one job is told of it all at once; requests do not
  /// wait behind it.
  std::deque<std::unique_ptr<Session>> ready_;
  std::deque<std::unique_ptr<Session>> streaming_;
  unsigned taken_ = 0;
  /// Sessions that threads work on, with their descriptors.
  std::map<std::uint64_t, int> busy_;
  std::atomic<bool> stopping_ = false;
  bool ended_ = false;
  std::vector<std::thread> pool_;
};

}  // namespace surfaced::http
