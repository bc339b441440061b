#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/base.hpp"
#include "http/connection.hpp"
#include "http/engine.hpp"
#include "platform/unique_fd.hpp"

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
  /// Connections that are served at once.
  std::size_t threads = 64;
  /// Connections that wait for a thread; more are answered 503.
  std::size_t waiting = 256;
  /// Requests on one connection.
  std::size_t requests = 1000;
};

/// Listens, accepts and gives connections to a pool of threads. A connection holds its thread from its
/// first byte to its last; both the threads and the connections that wait are bounded.
class Server {
 public:
  /// Binds and listens; port 0 takes a free one. invalid_usage if the address cannot be had.
  static Result<std::unique_ptr<Server>> listen(const Address& address, const ServerLimits& limits,
                                                const Router& router);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// http://host:port with the real port.
  std::string url() const;

  void start();

  /// Accepts no more, lets running exchanges end for this long, then cuts them off.
  void stop(std::chrono::milliseconds grace);

 private:
  /// Waiting for a request, answering one, or about to be closed.
  enum class Phase : std::uint8_t { idle, busy, gone };

  Server(UniqueFd listener, const ServerLimits& limits, const Router& router);
  void accept_loop();
  void pool_loop();
  void take(UniqueFd client);
  After serve(Connection& connection);
  void mark(int descriptor, Phase phase);
  static void turn_away(UniqueFd client);

  const ServerLimits limits_;
  Engine engine_;
  UniqueFd listener_;
  UniqueFd wake_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable idle_;
  std::deque<UniqueFd> queue_;
  /// By descriptor, the connections that hold a thread.
  std::map<int, Phase> active_;
  std::atomic<bool> stopping_ = false;
  std::thread acceptor_;
  std::vector<std::thread> pool_;
};

}  // namespace surfaced::http
