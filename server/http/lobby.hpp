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

#include "http/session.hpp"
#include "platform/unique_fd.hpp"

namespace surfaced::http {

/// The one thread in which connections wait: for a head, for an answer that is not known yet, for the client to
/// take its answer, for its last bytes before the close. Who waits here costs a descriptor and its buffer.
///
/// It also accepts. When all places are taken it closes the connection that has waited longest for a head in
/// favour of the new one, so that nobody keeps others out by staying silent; if all are at work or waiting for
/// answers, the new one is answered 503.
class Lobby {
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

  Lobby(int listener, const Options& options, Ready ready);
  ~Lobby();
  Lobby(const Lobby&) = delete;
  Lobby& operator=(const Lobby&) = delete;

  void start();

  /// A session that waits. Any thread.
  void enter(std::unique_ptr<Session> session);
  /// The answer that the session with this id waits for may be known. Any thread.
  void ring(std::uint64_t id);

  /// Accepts no more; ends what waits for a head, calls up what waits for an answer.
  void close();
  /// Ends everything that waits here, and the thread.
  void stop();

  /// Connections there are, here and at work.
  std::size_t connections() const { return places_; }
  std::uint64_t turned_away() const { return turned_away_; }
  /// Bytes of answers that clients have not taken, and clients that were cut off for it.
  std::uint64_t unsent_bytes() const { return unsent_bytes_; }
  std::uint64_t cut_off() const { return cut_off_; }

 private:
  struct Guest {
    std::unique_ptr<Session> session;
    Session::Clock::time_point deadline;
  };

  void run();
  void attend_to(std::uint64_t id);
  void take_mail();
  void accept_some();
  void admit(UniqueFd client);
  bool make_room();
  void seat(std::unique_ptr<Session> session);
  std::unique_ptr<Session> unseat(std::uint64_t id);
  void follow(std::uint64_t id, Session::Step step);
  void close_now();
  int wait_milliseconds() const;
  void end_overdue();
  void end_those_who_take_nothing();

  const Options options_;
  const Ready ready_;
  // Before the sessions, which give their places back.
  std::atomic<std::size_t> places_ = 0;
  std::atomic<std::uint64_t> turned_away_ = 0;
  std::atomic<std::uint64_t> unsent_bytes_ = 0;
  std::atomic<std::uint64_t> cut_off_ = 0;
  std::uint64_t next_id_;
  int listener_;
  UniqueFd epoll_;
  UniqueFd bell_;
  // Of the thread alone.
  std::unordered_map<std::uint64_t, Guest> guests_;
  std::set<std::pair<Session::Clock::time_point, std::uint64_t>> deadlines_;
  Unsent unsent_;
  bool closed_ = false;
  bool full_of_descriptors_ = false;
  // What other threads put in.
  std::mutex mutex_;
  std::vector<std::unique_ptr<Session>> arrivals_;
  std::vector<std::uint64_t> rings_;
  bool close_asked_ = false;
  std::atomic<bool> stop_asked_ = false;
  std::thread thread_;
};

}  // namespace surfaced::http
