// SPDX-License-Identifier: GPL-3.0-or-later
#include "execution/scheduler.hpp"

#include <unistd.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <string_view>
#include <utility>

#include "observability/survives.hpp"

namespace surfaced {
namespace {

/// After a failure that is not the job's (the store, the disk, a process that cannot be started).
constexpr std::chrono::milliseconds kPauseAfterFailure{1000};
/// Looking again without being told costs nothing and forgives a lost wake-up.
constexpr std::chrono::milliseconds kPatience{5000};
/// Those who watch a job hear of its progress no more often.
constexpr std::chrono::milliseconds kBetweenNews{500};

/// The meshes that the job wants besides the first.
std::vector<std::string> more_meshes(const Job& job) {
  std::vector<std::string> names;
  std::copy_if(std::next(job.wanted.begin()), job.wanted.end(), std::back_inserter(names),
               [](const std::string& name) { return name.starts_with("mesh."); });
  return names;
}

/// The name under which the job wants the method's cloud; empty if it does not.
std::string points_of(const Job& job) {
  constexpr std::string_view kName = "cloud.ply";
  return std::ranges::find(job.wanted, kName) != job.wanted.end() ? std::string(kName) : std::string();
}

/// A server, or a worker, has ended under an attempt at this job: perhaps by it.
bool was_lost(const Job& job) {
  return std::ranges::find(job.attempts, name_of(Outcome::lost), &Attempt::outcome) != job.attempts.end();
}

}  // namespace

Scheduler::Scheduler(JobStore& jobs, ArtifactStore& artifacts, JobEvents& events, const AttemptRunner& runner,
                     Options options)
    : jobs_(jobs), artifacts_(artifacts), events_(events), runner_(runner), options_(std::move(options)) {}

Scheduler::~Scheduler() { drain(std::chrono::milliseconds(0)); }

void Scheduler::start() {
  for (unsigned i = 0; i < options_.workers; ++i) threads_.emplace_back([this] { work(); });
  pulse_ = std::thread([this] { pulse(); });
}

void Scheduler::wake() {
  const std::scoped_lock lock(mutex_);
  ++submissions_;
  wake_.notify_all();
}

void Scheduler::cancel(std::string_view job) {
  const std::scoped_lock lock(mutex_);
  for (const Running& each : running_) {
    if (each.claim.job == job) each.stop->stop(Outcome::cancelled);
  }
}

void Scheduler::drain(std::chrono::milliseconds grace) {
  {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    wake_.notify_all();
    idle_.wait_for(lock, grace, [&] { return running_.empty(); });
    for (const Running& each : running_) each.stop->stop(Outcome::drained);
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  if (pulse_.joinable()) pulse_.join();
}

void Scheduler::pulse() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      // Until the last attempt has ended its lease is renewed, also while the server stops.
      wake_.wait_for(lock, options_.heartbeat, [&] { return stopping_ && running_.empty(); });
      if (stopping_ && running_.empty()) return;
    }
    survives("renew the leases of attempts", [this] { renew_leases(); });
    survives("give back jobs that nobody works on", [this] { expire_leases(); });
  }
}

void Scheduler::expire_leases() {
  const auto silent = jobs_.expire_leases();
  if (!silent || silent->empty()) return;
  for (const Claim& claim : *silent) events_.changed(claim.job);
  wake();
}

void Scheduler::renew_leases() {
  std::vector<Running> running;
  {
    const std::scoped_lock lock(mutex_);
    running = running_;
  }
  for (const Running& each : running) {
    const auto holds = jobs_.renew(each.claim);
    // If the store cannot say, the work goes on: settling is fenced.
    if (holds && !*holds) each.stop->stop(Outcome::cancelled);
  }
}

void Scheduler::work() {
  for (;;) {
    std::uint64_t seen = 0;
    {
      const std::scoped_lock lock(mutex_);
      if (stopping_) return;
      seen = submissions_;
    }
    Look look = Look::failed;
    survives("work on a job", [&] { look = work_on_next(); });
    if (look == Look::worked) continue;
    const bool nothing_to_do = look == Look::nothing_to_do;
    std::unique_lock lock(mutex_);
    const auto patience = nothing_to_do ? kPatience : kPauseAfterFailure;
    wake_.wait_for(lock, patience, [&] { return stopping_ || (nothing_to_do && submissions_ != seen); });
  }
}

Scheduler::Look Scheduler::work_on_next() {
  // An attempt without space would only be lost, and losses are counted.
  if (!artifacts_.check_space(0).ok()) return Look::failed;
  const auto claimed = jobs_.claim();
  if (!claimed) return Look::failed;
  if (!claimed->has_value()) return Look::nothing_to_do;
  const auto stop = std::make_shared<StopSignal>();
  {
    const std::scoped_lock lock(mutex_);
    running_.push_back({(*claimed)->claim(), stop});
    if (stopping_) stop->stop(Outcome::drained);
  }
  // Whatever the end: a job that is not settled is not renewed either, and given back when its lease is over.
  const bool whole = survives("end an attempt", [&] { run_claimed(**claimed, *stop); });
  const std::scoped_lock lock(mutex_);
  std::erase_if(running_, [&](const Running& each) { return each.stop == stop; });
  idle_.notify_all();
  if (stopping_) wake_.notify_all();
  return whole ? Look::worked : Look::failed;
}

void Scheduler::run_claimed(const ClaimedJob& claimed, StopSignal& stop) {
  events_.changed(claimed.job.id);
  // The job may have been dismissed between its claim and its entry above; nobody would stop it then.
  const auto now = jobs_.find(claimed.job.id);
  if (!now || now->status != JobStatus::running) stop.stop(Outcome::cancelled);
  StageClock stages;
  const AttemptResult result = attempt_safely(claimed, stop, stages);
  stages.close();
  if (options_.ended) options_.ended({claimed, result, stages.stages()});
  settle(claimed, result);
  events_.changed(claimed.job.id);
}

AttemptResult Scheduler::attempt_safely(const ClaimedJob& claimed, const StopSignal& stop, StageClock& stages) {
  try {
    return attempt(claimed, stop, stages);
  } catch (const std::exception& failure) {
    return {Outcome::lost, Error{ErrorCode::internal_error, failure.what()}};
  }
}

AttemptResult Scheduler::attempt(const ClaimedJob& claimed, const StopSignal& stop, StageClock& stages) {
  if (const auto why = stop.why()) return {*why, Error{ErrorCode::cancelled, "the work was stopped"}};
  const Claim claim = claimed.claim();
  const auto directory = artifacts_.begin_attempt(claim);
  if (!directory) return {Outcome::lost, directory.error()};
  const auto cloud = artifacts_.input_file(claimed.job.input.key);
  if (!cloud) return {Outcome::lost, cloud.error()};
  auto log = AttemptLog::create(*directory / "log.txt");
  if (!log) return {Outcome::lost, log.error()};
  log->line("job " + claim.job + " attempt " + std::to_string(claim.attempt) + " request " + claimed.job.request_id);
  log->line("method " + claimed.job.method + " " + claimed.job.parameters.dump());
  log->line("input " + std::to_string(claimed.job.input.bytes) + " bytes, sha256 " + claimed.job.input.sha256);
  AttemptSpec spec{claim,
                   claimed.job.method,
                   claimed.job.parameters,
                   *cloud,
                   claimed.job.input.sha256,
                   *directory,
                   claimed.job.wanted.front(),
                   points_of(claimed.job),
                   options_.limits,
                   ::getpid(),
                   claimed.job.traceparent,
                   more_meshes(claimed.job)};
  spec.guarded = was_lost(claimed.job);
  if (spec.guarded) log->line("an attempt was lost before: this one is watched by a process of its own");
  auto told = std::chrono::steady_clock::time_point();
  AttemptResult result = runner_.run(spec, stop, *log, [&](double progress, std::string_view phase) {
    stages.enter(phase);
    jobs_.report(claim, progress, phase);
    const auto time = std::chrono::steady_clock::now();
    if (time - told < kBetweenNews) return;
    told = time;
    events_.changed(claim.job);
  });
  log->close();
  log->line("outcome " + std::string(name_of(result.outcome)) + (result.error ? ": " + result.error->detail : ""));
  return result;
}

void Scheduler::settle(const ClaimedJob& claimed, AttemptResult result) {
  const Claim claim = claimed.claim();
  const std::vector<Output> outputs = publish(claimed.job, result);
  for (;;) {
    const auto status = jobs_.settle(claim, {result.outcome, result.error, outputs, result.usage});
    if (status) {
      const bool kept = status->has_value() && ended(**status) && !outputs.empty();
      if (!kept) artifacts_.discard(claim);
      if (result.outcome == Outcome::lost) pause_after_failure();
      return;
    }
    // The outputs stay where they are: if the server ends before the store works again, the next start
    // recovers the job and sweeps what the store does not know.
    if (!pause_after_failure()) return;
  }
}

std::vector<Output> Scheduler::publish(const Job& job, AttemptResult& result) {
  const Outcome outcome = result.outcome;
  if (outcome == Outcome::cancelled || outcome == Outcome::drained || outcome == Outcome::lost) return {};
  // Of an attempt that failed only the log is worth keeping.
  auto names = outcome == Outcome::done ? job.wanted : std::vector<std::string>{"log.txt"};
  const std::size_t promised = names.size();
  if (outcome == Outcome::done) names.emplace_back(kKeptMesh);
  auto published = artifacts_.publish({job.id, job.attempt}, names);
  if (!published) {
    const bool by_child = published.error().code == ErrorCode::crashed;
    result.outcome = by_child ? Outcome::crashed : Outcome::lost;
    result.error = published.error();
    return {};
  }
  const auto made = std::ranges::count_if(*published, [](const Output& output) { return output.name != kKeptMesh; });
  if (static_cast<std::size_t>(made) < promised) {
    result.outcome = Outcome::crashed;
    result.error = Error{ErrorCode::crashed, "the process ended without writing its outputs"};
    std::erase_if(*published, [](const Output& output) { return output.name != "log.txt"; });
  }
  return std::move(*published);
}

bool Scheduler::pause_after_failure() {
  std::unique_lock lock(mutex_);
  return !wake_.wait_for(lock, kPauseAfterFailure, [&] { return stopping_; });
}

}  // namespace surfaced
