// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_runner.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <iterator>

#include "worker/attempt_bounds.hpp"
#include "worker/child_process.hpp"
#include "worker/guard_main.hpp"
#include "worker/overuse.hpp"

namespace surfaced {
namespace {

using Clock = std::chrono::steady_clock;

/// Between TERM and KILL. A guard gets the time for that, and to tell of it.
constexpr std::chrono::milliseconds kGrace{500};
constexpr std::chrono::milliseconds kGraceOfGuard{1500};
/// What a child that has ended may have left in a pipe.
constexpr std::size_t kMaxLeftover = std::size_t{1} << 20;
/// Between two looks at what the child uses.
constexpr std::chrono::milliseconds kWatchInterval{100};

/// Hands on what can be read now, up to a limit; false at the end of the stream.
template <class Sink>
bool drain(int fd, std::size_t limit, const Sink& sink) {
  std::array<char, 16384> buffer{};
  for (std::size_t total = 0; total < limit;) {
    const ssize_t count = ::read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno == EAGAIN;
    if (count == 0) return false;
    total += static_cast<std::size_t>(count);
    sink(std::string_view(buffer.data(), static_cast<std::size_t>(count)));
  }
  return true;
}

/// A child under watch.
class Watch {
 public:
  Watch(ChildProcess& child, const AttemptSpec& spec, const StopSignal& stop, AttemptLog& log,
        const AttemptRunner::ProgressSink& progress)
      : child_(child),
        spec_(spec),
        stop_(stop),
        log_(log),
        progress_(progress),
        deadline_(Clock::now() + spec.limits.time) {}

  /// Returns once the child has ended or was killed.
  void until_end() {
    std::array<pollfd, 4> fds{{{child_.ended_descriptor(), POLLIN, 0},
                               {child_.messages(), POLLIN, 0},
                               {child_.output(), POLLIN, 0},
                               {stop_.descriptor(), POLLIN, 0}}};
    auto& [ended, messages, output, stop] = fds;
    while (!killed_) {
      const int count = ::poll(fds.data(), fds.size(), milliseconds_left());
      if (count < 0 && errno != EINTR) break;
      look_at_the_clock();
      if (messages.revents != 0 && !read_messages()) messages.fd = -1;
      if (output.revents != 0 && !read_output()) output.fd = -1;
      if (ended.revents != 0) break;
      if (stop.revents != 0) {
        stop.fd = -1;
        ask_to_end();
      }
    }
    read_messages();
    read_output();
  }

  bool timed_out() const { return timed_out_; }
  /// For which it was killed.
  const std::optional<Overuse>& overuse() const { return overuse_; }
  const std::optional<Error>& problem() const { return problem_; }

 private:
  int milliseconds_left() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline_ - Clock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, kWatchInterval.count()));
  }

  void look_at_the_clock() {
    const auto time = Clock::now();
    if (time >= next_look_) {
      next_look_ = time + kWatchInterval;
      end_if(overuse_of(child_, spec_));
    }
    if (time < deadline_) return;
    if (asked_) {
      child_.kill();
      killed_ = true;
    } else {
      timed_out_ = true;
      ask_to_end();
    }
  }

  void end_if(std::optional<Overuse> overuse) {
    if (!overuse) return;
    overuse_ = std::move(overuse);
    child_.kill();
    killed_ = true;
  }

  /// Reading costs the server time, whatever becomes of the bytes.
  void count(std::size_t bytes) {
    output_bytes_ += bytes;
    if (output_bytes_ <= kMostOutput || killed_) return;
    end_if(Overuse{Outcome::crashed, Error{ErrorCode::crashed, "the work said more than the limit of " +
                                                                   std::to_string(kMostOutput) + " bytes"}});
  }

  void ask_to_end() {
    if (asked_) return;
    asked_ = true;
    deadline_ = Clock::now() + (spec_.guarded ? kGraceOfGuard : kGrace);
    child_.signal_group(SIGTERM);
  }

  bool read_messages() {
    return drain(child_.messages(), kMaxLeftover, [&](std::string_view bytes) {
      count(bytes.size());
      splitter_.add(bytes, [&](std::string_view line) {
        const Message message = decode_message(line);
        if (const auto* progress = std::get_if<ProgressMessage>(&message))
          progress_(progress->progress, progress->phase);
        if (const auto* problem = std::get_if<Error>(&message)) problem_ = *problem;
      });
    });
  }

  bool read_output() {
    return drain(child_.output(), kMaxLeftover, [&](std::string_view bytes) {
      count(bytes.size());
      log_.child_output(bytes);
    });
  }

  ChildProcess& child_;
  const AttemptSpec& spec_;
  const StopSignal& stop_;
  AttemptLog& log_;
  const AttemptRunner::ProgressSink& progress_;
  Clock::time_point deadline_;
  Clock::time_point next_look_;
  LineSplitter splitter_;
  std::optional<Error> problem_;
  bool asked_ = false;
  bool killed_ = false;
  bool timed_out_ = false;
  std::optional<Overuse> overuse_;
  std::uint64_t output_bytes_ = 0;
};

/// What the child's own words mean for its job.
Outcome outcome_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::method_failed:
      return Outcome::method_failed;
    case ErrorCode::out_of_memory:
      return Outcome::out_of_memory;
    case ErrorCode::timed_out:
      return Outcome::timed_out;
    case ErrorCode::internal_error:
    case ErrorCode::crashed:
      return Outcome::crashed;
    // The disk is full, the server has gone, the kernel takes no confinement: not the input's fault.
    case ErrorCode::not_ready:
    case ErrorCode::storage_full:
    case ErrorCode::output_not_writable:
    case ErrorCode::input_unreadable:
    case ErrorCode::cancelled:
    case ErrorCode::lost:
      return Outcome::lost;
    default:
      return Outcome::input_invalid;
  }
}

std::string name_of_signal(int signal) {
  const char* name = ::sigabbrev_np(signal);
  return name == nullptr ? std::to_string(signal) : "SIG" + std::string(name);
}

AttemptResult judge_exit(const ChildProcess::Exit& exit, const std::optional<Error>& problem, const AttemptSpec& spec) {
  if (exit.signal == SIGXCPU) {
    return {Outcome::timed_out, Error{ErrorCode::timed_out, "the work took more processor time than " +
                                                                std::to_string(spec.limits.time.count()) + " s on " +
                                                                std::to_string(spec.limits.threads) + " threads"}};
  }
  if (exit.signal == SIGXFSZ) {
    return {Outcome::method_failed,
            Error{ErrorCode::method_failed,
                  "an output would be larger than the limit of " + std::to_string(spec.limits.file_bytes) + " bytes"}};
  }
  if (exit.signal != 0) {
    const char* const why = exit.signal == SIGSYS ? ", for a system call that an attempt may not make" : "";
    return {Outcome::crashed,
            Error{ErrorCode::crashed, "the process was ended by the signal " + name_of_signal(exit.signal) + why}};
  }
  if (exit.code == 0 && !problem) return {Outcome::done, {}};
  if (exit.code != 0 && problem) return {outcome_of(problem->code), problem};
  return {Outcome::crashed,
          Error{ErrorCode::crashed, "the process ended with exit code " + std::to_string(exit.code) +
                                        (problem ? " although it reported a problem" : " without a reason")}};
}

AttemptResult judge(const ChildProcess::Exit& exit, const Watch& watch, const StopSignal& stop,
                    const AttemptSpec& spec) {
  if (const auto why = stop.why()) return {*why, Error{ErrorCode::cancelled, "the work was stopped"}};
  if (watch.timed_out()) {
    return {Outcome::timed_out, Error{ErrorCode::timed_out, "the work took longer than the limit of " +
                                                                std::to_string(spec.limits.time.count()) + " s"}};
  }
  if (watch.overuse()) return {watch.overuse()->outcome, watch.overuse()->error};
  return judge_exit(exit, watch.problem(), spec);
}

/// What is there now was there when the child looked for it: nothing comes back.
bool are_there(const AttemptSpec& spec) {
  std::error_code error;
  return std::filesystem::exists(spec.cloud, error) && std::filesystem::exists(spec.directory, error);
}

}  // namespace

AttemptResult AttemptRunner::run(const AttemptSpec& spec, const StopSignal& stop, AttemptLog& log,
                                 const ProgressSink& progress) const {
  std::vector<std::string> command = command_;
  if (spec.guarded) command.insert(std::next(command.begin()), kGuardCommand);
  command.push_back(encode(spec));
  const auto began = Clock::now();
  const auto namespaces = spec.guarded ? ChildProcess::Namespaces::shared : namespaces_.load();
  auto run = run_once(command, namespaces, spec, stop, log, progress);
  // A job that is ended and removed while it starts says nothing about what this machine can do.
  if (run && (run->cannot_be_contained || run->paths_not_reached) && !stop.why()) {
    if (run->cannot_be_contained || are_there(spec)) namespaces_ = ChildProcess::Namespaces::shared;
    run = run_once(command, ChildProcess::Namespaces::shared, spec, stop, log, progress);
  }
  if (!run) return {Outcome::lost, run.error()};
  run->result.usage.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  return std::move(run->result);
}

Result<AttemptRunner::Run> AttemptRunner::run_once(const std::vector<std::string>& command,
                                                   ChildProcess::Namespaces namespaces, const AttemptSpec& spec,
                                                   const StopSignal& stop, AttemptLog& log,
                                                   const ProgressSink& progress) const {
  auto child = ChildProcess::start(command, namespaces);
  if (!child) return child.error();
  Watch watch(*child, spec, stop, log, progress);
  watch.until_end();
  const ChildProcess::Exit exit = child->reap();
  Run run{judge(exit, watch, stop, spec), exit.cannot_be_contained, exit.paths_not_reached};
  run.result.usage.cpu_seconds = exit.cpu_seconds;
  run.result.usage.peak_memory_bytes = exit.peak_memory_bytes;
  return run;
}

}  // namespace surfaced
