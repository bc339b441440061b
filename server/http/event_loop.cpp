// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/event_loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>

#include "http/problem.hpp"
#include "observability/survives.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

constexpr std::uint64_t kListener = 0;
constexpr std::uint64_t kWakeup = 1;
constexpr std::uint64_t kFirstSession = 2;
constexpr int kAcceptedAtOnce = 64;
/// When descriptors run out, accepting again at once would only spin.
constexpr int kPauseWithoutDescriptors = 50;
constexpr int kLongestSleep = 60'000;
/// While clients have more of their answers to take than they should.
constexpr int kPauseWhileShort = 100;

void register_with(int epoll, int fd, std::uint32_t events, std::uint64_t id) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  if (::epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event) != 0) throw std::bad_alloc();
}

void refuse(const UniqueFd& client) {
  const std::string answer =
      closing_answer({ErrorCode::not_ready, "all connections of the server are taken"}, random_hex<12>());
  // What has arrived is taken first, or the close would reset the connection before the answer is read.
  std::array<char, 16384> dropped{};
  for (int i = 0; i < 4 && ::recv(client.get(), dropped.data(), dropped.size(), MSG_DONTWAIT) > 0; ++i) {
  }
  [[maybe_unused]] const ssize_t sent = ::send(client.get(), answer.data(), answer.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  ::shutdown(client.get(), SHUT_WR);
}

}  // namespace

EventLoop::EventLoop(int listener, const Options& options, Ready ready)
    : options_(options),
      ready_(std::move(ready)),
      next_id_(kFirstSession),
      listener_(listener),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      wakeup_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      unsent_(options.unsent) {
  register_with(epoll_.get(), wakeup_.get(), EPOLLIN, kWakeup);
  register_with(epoll_.get(), listener_, EPOLLIN, kListener);
}

EventLoop::~EventLoop() { stop(); }

void EventLoop::start() {
  thread_ = std::thread([this] { run(); });
}

void EventLoop::add(std::unique_ptr<Session> session) {
  bool first = false;
  {
    const std::scoped_lock lock(mutex_);
    first = added_.empty() && woken_.empty();
    added_.push_back(std::move(session));
  }
  // Whoever asked before has woken the thread, and it takes all at once.
  if (first) ::eventfd_write(wakeup_.get(), 1);
}

void EventLoop::wake(std::uint64_t id) {
  bool first = false;
  {
    const std::scoped_lock lock(mutex_);
    first = added_.empty() && woken_.empty();
    woken_.push_back(id);
  }
  if (first) ::eventfd_write(wakeup_.get(), 1);
}

void EventLoop::close() {
  {
    const std::scoped_lock lock(mutex_);
    close_asked_ = true;
  }
  ::eventfd_write(wakeup_.get(), 1);
}

void EventLoop::stop() {
  stop_asked_ = true;
  ::eventfd_write(wakeup_.get(), 1);
  if (thread_.joinable()) thread_.join();
  waiting_.clear();
  // Ended outside of the lock: a session that ends unsubscribes, and whoever wakes it holds the other lock.
  std::vector<std::unique_ptr<Session>> added;
  {
    const std::scoped_lock lock(mutex_);
    added.swap(added_);
  }
}

void EventLoop::run() {
  std::array<epoll_event, 256> events{};
  while (!stop_asked_) {
    const int count = ::epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), wait_milliseconds());
    if (full_of_descriptors_ && !closed_) {
      full_of_descriptors_ = false;
      register_with(epoll_.get(), listener_, EPOLLIN, kListener);
    }
    for (int i = 0; i < count; ++i) {
      // Memory may run out for one connection; the others go on.
      survives("go on with a connection", [&] { handle_event(events.at(static_cast<std::size_t>(i)).data.u64); });
    }
    survives("end connections", [this] {
      end_overdue();
      cut_off_stalled();
    });
  }
}

void EventLoop::handle_event(std::uint64_t id) {
  if (id == kWakeup) {
    take_requests();
  } else if (id == kListener) {
    accept_some();
  } else if (const auto found = waiting_.find(id); found != waiting_.end()) {
    follow(id, found->second.session->advance());
  }
}

int EventLoop::wait_milliseconds() const {
  if (full_of_descriptors_) return kPauseWithoutDescriptors;
  const int longest = unsent_.is_short() ? kPauseWhileShort : kLongestSleep;
  if (deadlines_.empty()) return longest;
  const auto left = deadlines_.begin()->first - Session::Clock::now();
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(left).count();
  return static_cast<int>(std::clamp<std::int64_t>(milliseconds, 0, longest));
}

void EventLoop::take_requests() {
  eventfd_t count = 0;
  ::eventfd_read(wakeup_.get(), &count);
  std::vector<std::unique_ptr<Session>> added;
  std::vector<std::uint64_t> woken;
  bool close_asked = false;
  {
    const std::scoped_lock lock(mutex_);
    added.swap(added_);
    woken.swap(woken_);
    close_asked = std::exchange(close_asked_, false);
  }
  if (close_asked) close_now();
  for (auto& session : added) {
    if (closed_ && session->before_request()) continue;
    if (session->waits_for_response() && (closed_ || session->woken())) {
      ready_(std::move(session));
    } else {
      watch(std::move(session));
    }
  }
  for (const std::uint64_t id : woken) {
    const auto found = waiting_.find(id);
    if (found != waiting_.end() && found->second.session->waits_for_response()) ready_(unwatch(id));
  }
}

void EventLoop::close_now() {
  closed_ = true;
  if (!full_of_descriptors_) ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, listener_, nullptr);
  std::vector<std::uint64_t> ids;
  for (const auto& [id, waiting] : waiting_) ids.push_back(id);
  for (const std::uint64_t id : ids) {
    const Session& session = *waiting_.at(id).session;
    if (session.before_request()) {
      unwatch(id);
    } else if (session.waits_for_response()) {
      ready_(unwatch(id));
    }
  }
}

void EventLoop::accept_some() {
  for (int i = 0; i < kAcceptedAtOnce; ++i) {
    UniqueFd client(::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (client) {
      admit(std::move(client));
      continue;
    }
    if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      full_of_descriptors_ = true;
      ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, listener_, nullptr);
    }
    return;
  }
}

void EventLoop::admit(UniqueFd client) {
  if (open_ >= options_.connections && !evict_one()) {
    ++turned_away_;
    // Who expects TLS could not read the reason.
    if (options_.tls == nullptr) refuse(client);
    return;
  }
  const std::uint64_t id = next_id_++;
  auto session =
      std::make_unique<Session>(id, std::move(client), options_.connection, options_.requests, open_, options_.tls);
  Session& seen = *session;
  watch(std::move(session));
  // Often the head has arrived together with the connection.
  follow(id, seen.advance());
}

bool EventLoop::evict_one() {
  for (const auto& [deadline, id] : deadlines_) {
    const Session& session = *waiting_.at(id).session;
    if (!session.before_request() && !session.lingers()) continue;
    session.give_up();
    unwatch(id);
    ++turned_away_;
    return true;
  }
  return false;
}

void EventLoop::watch(std::unique_ptr<Session> session) {
  const std::uint64_t id = session->id();
  const auto deadline = session->deadline();
  const Session& seen = *session;
  waiting_.emplace(id, Waiting{std::move(session), deadline});
  try {
    deadlines_.emplace(deadline, id);
    unsent_.note(id, seen.share(), Session::Clock::now());
    register_with(epoll_.get(), seen.descriptor(), seen.events(), id);
  } catch (const std::exception&) {
    // One that would be forgotten in part is ended.
    unwatch(id);
    throw;
  }
}

std::unique_ptr<Session> EventLoop::unwatch(std::uint64_t id) {
  const auto found = waiting_.find(id);
  std::unique_ptr<Session> session = std::move(found->second.session);
  deadlines_.erase({found->second.deadline, id});
  unsent_.forget(id);
  waiting_.erase(found);
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, session->descriptor(), nullptr);
  return session;
}

void EventLoop::follow(std::uint64_t id, Session::Step step) {
  if (step == Session::Step::over) {
    unwatch(id);
    return;
  }
  if (step == Session::Step::ready) {
    ready_(unwatch(id));
    return;
  }
  Waiting& waiting = waiting_.at(id);
  const auto deadline = waiting.session->deadline();
  if (deadline != waiting.deadline) {
    deadlines_.emplace(deadline, id);
    deadlines_.erase({waiting.deadline, id});
    waiting.deadline = deadline;
  }
  // Writing may have become waiting for the next head, or lingering.
  epoll_event event{};
  event.events = waiting.session->events();
  event.data.u64 = id;
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, waiting.session->descriptor(), &event);
  unsent_.note(id, waiting.session->share(), Session::Clock::now());
}

void EventLoop::cut_off_stalled() {
  const auto time = Session::Clock::now();
  while (const auto id = unsent_.overdue(time)) {
    const Session& session = *waiting_.at(*id).session;
    // It may have taken something of what the kernel holds, of which nobody is told.
    unsent_.note(*id, session.share(), time);
    if (unsent_.overdue(time) != id) continue;
    session.give_up();
    unwatch(*id);
    ++cut_off_;
  }
  unsent_bytes_ = unsent_.bytes();
}

void EventLoop::end_overdue() {
  const auto time = Session::Clock::now();
  while (!deadlines_.empty() && deadlines_.begin()->first <= time) {
    const std::uint64_t id = deadlines_.begin()->second;
    follow(id, waiting_.at(id).session->overdue());
  }
}

}  // namespace surfaced::http
