// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "api/job_service.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// Where a client of the event stream stands; written into every event's id, so that the stream resumes where it broke
/// off, also after a restart of the server.
struct EventPosition {
  std::uint32_t attempt = 0;
  /// Bytes of the attempt's log that the client has.
  std::uint64_t log = 0;
  /// The state that it knows; empty for none, `done` once it has everything.
  std::string state;
};
std::string event_id(const EventPosition& position);
/// None for what event_id never writes.
std::optional<EventPosition> read_event_id(std::string_view text);

/// One job and its log as all their streams see them: looked up once a change, however many follow it.
class JobLook {
 public:
  JobLook(JobService& service, std::string job);

  std::shared_ptr<const Result<Job>> get();
  /// What the attempt's log has from the offset on, a bounded piece of it, as of the last `get` or later; empty if
  /// there is nothing or the log is gone. Streams that stand at the same place share one reading.
  std::shared_ptr<const std::string> log(const Job& job, std::uint64_t offset);
  /// A piece of this length may have more behind it.
  static constexpr std::size_t kLogPiece = std::size_t{32} << 10;

 private:
  JobService& service_;
  const std::string job_;
  std::atomic<bool> fresh_ = false;
  std::mutex mutex_;
  std::shared_ptr<const Result<Job>> seen_;
  std::chrono::steady_clock::time_point when_;
  // Of the last reading; forgotten with the next look at the job.
  std::shared_ptr<const std::string> log_;
  std::uint32_t log_attempt_ = 0;
  std::uint64_t log_offset_ = 0;
  // One for all streams, made before theirs: if each of a thousand made the look outdated when it is woken, each would
  // look again. Last, so that nobody is told who is half gone.
  std::shared_ptr<void> subscription_;
};

/// The looks that streams share, by job.
class JobLooks {
 public:
  explicit JobLooks(JobService& service) : service_(service) {}
  std::shared_ptr<JobLook> at(const std::string& job);

 private:
  JobService& service_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::weak_ptr<JobLook>> looks_;
};

/// Server-Sent Events of one job for one client: `state` whenever the job's status or attempt changes, `progress`,
/// `log`, and `done`, which is the last.
class EventStream {
 public:
  EventStream(std::shared_ptr<JobLook> look, std::string job, EventPosition position)
      : look_(std::move(look)), job_(std::move(job)), position_(std::move(position)) {}

  http::StreamingResponse::Chunk next();

 private:
  void add(std::string& bytes, std::string_view event, const nlohmann::ordered_json& data) const;
  void add_state(std::string& bytes, const Job& job);
  void add_progress(std::string& bytes, const Job& job);
  /// False while there is more of the log.
  bool add_log(std::string& bytes, const Job& job);

  const std::shared_ptr<JobLook> look_;
  const std::string job_;
  EventPosition position_;
  double progress_ = -1;
  std::string phase_;
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

}  // namespace surfaced::api
