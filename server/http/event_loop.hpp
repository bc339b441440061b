// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/unique_fd.hpp"
#include "http/session.hpp"

namespace surfaced::http {

/// The one thread (epoll) in which connections wait: for a head, for a deferred response, for the client to take its
/// answer, for its last bytes before the close. A connection that waits here costs a descriptor and its buffer.
///
/// It also accepts. At the limit of connections it closes the one that has waited longest for a head in favour of the
/// new one, so that nobody keeps others out by staying silent; if all are at work or waiting for responses, the new one
/// is answered 503.
class EventLoop {
 public:
  struct Options {
    ConnectionLimits connection;
    std::size_t connections = 2000;
    std::size_t requests = 1000;
    Unsent::Limits unsent;
    /// None for plain HTTP.
    const Tls* tls = nullptr;
  };
  /// Takes over a session that has work to be done; must not block.
  using Ready = std::function<void(std::unique_ptr<Session>)>;

  EventLoop(int listener, const Options& options, Ready ready);
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  void start();

  /// A session that waits. Any thread.
  void add(std::unique_ptr<Session> session);
  /// The response that the session with this id waits for may be known. Any thread.
  void wake(std::uint64_t id);

  /// Accepts no more; ends what waits for a head, hands on what waits for a response.
  void close();
  /// Ends everything that waits here, and the thread.
  void stop();

  /// Connections there are, here and at work.
  std::size_t connections() const { return open_; }
  /// Connections that were refused, or closed for a new one.
  std::uint64_t turned_away() const { return turned_away_; }
  /// Bytes of answers that clients have not taken, and clients that were cut off for it.
  std::uint64_t unsent_bytes() const { return unsent_bytes_; }
  std::uint64_t cut_off() const { return cut_off_; }

 private:
  struct Waiting {
    std::unique_ptr<Session> session;
    Session::Clock::time_point deadline;
  };

  void run();
  void handle_event(std::uint64_t id);
  void take_requests();
  void accept_some();
  void admit(UniqueFd client);
  bool evict_one();
  void watch(std::unique_ptr<Session> session);
  std::unique_ptr<Session> unwatch(std::uint64_t id);
  void follow(std::uint64_t id, Session::Step step);
  void close_now();
  int wait_milliseconds() const;
  void end_overdue();
  void cut_off_stalled();

  const Options options_;
  const Ready ready_;
  // Before the sessions, which count down when they end.
  std::atomic<std::size_t> open_ = 0;
  std::atomic<std::uint64_t> turned_away_ = 0;
  std::atomic<std::uint64_t> unsent_bytes_ = 0;
  std::atomic<std::uint64_t> cut_off_ = 0;
  std::uint64_t next_id_;
  int listener_;
  UniqueFd epoll_;
  UniqueFd wakeup_;
  // Of the thread alone.
  std::unordered_map<std::uint64_t, Waiting> waiting_;
  std::set<std::pair<Session::Clock::time_point, std::uint64_t>> deadlines_;
  Unsent unsent_;
  bool closed_ = false;
  bool full_of_descriptors_ = false;
  // What other threads ask for.
  std::mutex mutex_;
  std::vector<std::unique_ptr<Session>> added_;
  std::vector<std::uint64_t> woken_;
  bool close_asked_ = false;
  std::atomic<bool> stop_asked_ = false;
  std::thread thread_;
};

}  // namespace surfaced::http
