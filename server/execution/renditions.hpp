// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "artifacts/artifact_store.hpp"
#include "jobs/job_events.hpp"
#include "jobs/job_store.hpp"
#include "worker/side_task.hpp"

namespace surfaced {

/// Other formats of a job's mesh, made by a child when they are first asked for, and kept with the job's outputs from
/// then on. A format is made once, however many ask for it; a bounded number is made at once and a bounded number
/// waits, of the jobs of one key fewer. They are made in the order in which they were asked for, first those that a
/// request still waits for; the others give way when there is no room.
class Renditions {
 public:
  Renditions(JobStore& jobs, ArtifactStore& artifacts, const SideTask& task)
      : jobs_(jobs), artifacts_(artifacts), task_(task) {}
  ~Renditions() { stop(); }
  Renditions(const Renditions&) = delete;
  Renditions& operator=(const Renditions&) = delete;

  /// A format that was asked for; whoever asks for the same one meanwhile shares it.
  struct Order {
    std::string job;
    std::string name;
    std::uint32_t number = 0;
    /// Of the job.
    std::string owner;
    /// Set once; belongs to the Renditions until then.
    std::optional<Result<Output>> result;
  };

  void start();

  /// Has a mesh of a successful job made; does not wait.
  /// @param number  of the format; two formats of a job have different ones
  /// @return  whoever waits keeps it; not_ready if so many wait already, too_many_requests if so many of the owner do.
  Result<std::shared_ptr<const Order>> order(const Job& job, const std::string& name, std::uint32_t number);

  /// What became of it, if that is known: the output, or job_gone, not_ready, what the child says.
  std::optional<Result<Output>> made(const Order& order);

  /// Calls the function when that becomes known, as JobEvents does.
  std::shared_ptr<void> watch(const Order& order, std::function<void()> wake);

  /// Ends the children that may be running, and refuses from then on.
  void stop();

 private:
  void work();
  /// Room for one more in the queue, at the cost of those that nobody waits for.
  Status make_room(const std::string& owner);
  /// None when the threads are to end.
  std::shared_ptr<Order> next();
  /// Made meanwhile by somebody else, or made now.
  Result<Output> make(const Order& order);
  /// What is thrown ends the order, not the server.
  Result<Output> make_safely(const Order& order);

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  const SideTask& task_;
  StopSignal stop_;
  JobEvents events_;
  std::mutex mutex_;
  std::condition_variable changed_;
  /// Those without a result, by what they are for.
  std::map<std::string, std::shared_ptr<Order>> orders_;
  std::deque<std::shared_ptr<Order>> waiting_;
  std::vector<std::thread> threads_;
};

}  // namespace surfaced
