// SPDX-License-Identifier: GPL-3.0-or-later
// A job and its states.
//
//   submit --> accepted --claim--> running --finish--> successful
//                 ^  |               | | |---fail----> failed
//                 |  |---dismiss--.  | |
//                 |               v  v |
//                 |            dismissed (by the client)
//                 |------------- give back: the attempt was lost, drained, or crashed for the first time
//                 '------------- retry (by the client) of a failed or dismissed job
//
// `successful`, `failed` and `dismissed` are ends; a failed job is parked if it had used up its attempts. An
// ended job is removed by its client or when its time to live is over; its id then answers "gone" for
// another while.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "platform/clock.hpp"

namespace surfaced {

enum class JobStatus : std::uint8_t { accepted, running, successful, failed, dismissed };

std::string_view name_of(JobStatus status);
std::optional<JobStatus> job_status_named(std::string_view name);
inline bool ended(JobStatus status) { return status > JobStatus::running; }

/// A file that an attempt left, as it was when the attempt was committed.
/// The mesh without any loss, which an attempt writes if the first format that was asked for loses some of it. Further
/// formats are made of it; clients do not see it.
inline constexpr std::string_view kKeptMesh = "kept.ply";

struct Output {
  std::string name;
  std::uint32_t attempt = 0;
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// A cloud as it was uploaded; `key` is its name in the artifact store.
struct StoredInput {
  std::string key;
  std::uint64_t bytes = 0;
  std::string sha256;
};

// nlohmann declares its move noexcept; the analyzer follows its assertions.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct NewJob {
  std::string id;
  std::string method;
  /// As check_parameters returns them.
  nlohmann::ordered_json parameters;
  StoredInput input;
  /// Names of the outputs to make: first the mesh, in the format of its name, then cloud.ply if it is wanted,
  /// report.json and log.txt.
  std::vector<std::string> wanted;
  /// Of the request that made the job.
  std::string request_id;
  /// The W3C trace context that the request carried; empty if it carried none.
  std::string traceparent;
  /// How long the job is kept after its end.
  std::chrono::seconds ttl{};
  /// Id of the key that it was submitted with; empty if the server has no keys.
  std::string owner{};
  std::vector<std::string> labels{};
  /// Who is told of its end; empty for nobody.
  std::string webhook{};
  /// What the client calls this submission, so that repeating it makes no second job; may be empty.
  std::string idempotency_key{};
  /// Hash of everything that the submission asks for.
  std::string fingerprint{};
  /// How the endpoint that took it will show its results; of no meaning to anybody else.
  std::string presentation{};

  /// True if its input is a stored cloud, which other jobs may use too.
  bool of_stored_cloud() const { return !input.key.empty() && input.key == input.sha256; }
};

/// What an attempt used.
struct Usage {
  double seconds = 0;
  double cpu_seconds = 0;
  std::uint64_t peak_memory_bytes = 0;
};

/// A claim of the job as it went, in the list of its attempts.
struct Attempt {
  std::uint32_t number = 0;
  SystemTime started_at;
  /// None while it runs.
  std::optional<SystemTime> ended_at;
  /// Name of its Outcome; empty while it runs.
  std::string outcome;
  Usage usage;
  std::optional<Error> error;
};

struct Job : NewJob {
  JobStatus status = JobStatus::accepted;
  double progress = 0;
  std::string phase;
  /// Jobs that wait before this one; none unless accepted.
  std::optional<std::uint64_t> queue_position;
  /// Times the job was claimed; the fencing token of the last claim.
  std::uint32_t attempt = 0;
  SystemTime created_at;
  std::optional<SystemTime> started_at;
  std::optional<SystemTime> finished_at;
  std::optional<SystemTime> expires_at;
  std::optional<Error> error;
  /// It failed because it may not be attempted again; only its client can start it anew.
  bool parked = false;
  std::vector<Output> outputs;
  /// The latest ones, oldest first.
  std::vector<Attempt> attempts;
};

/// The right to work on a job. It is void as soon as the job is dismissed or claimed again, or its lease has run
/// out because nobody renewed it: whatever is then said in its name changes nothing.
struct Claim {
  std::string job;
  std::uint32_t attempt = 0;
};

/// How an attempt ended.
enum class Outcome : std::uint8_t {
  done,
  /// The input was refused; the error says why.
  input_invalid,
  method_failed,
  out_of_memory,
  timed_out,
  crashed,
  /// The client dismissed the job.
  cancelled,
  /// The server died, its lease ran out, or it could not do its part (spawn, store); says nothing about the input.
  lost,
  /// The server is stopping.
  drained,
};

std::string_view name_of(Outcome outcome);

/// What went wrong with a job in earlier attempts.
struct FailureCounts {
  std::uint32_t failures = 0;
  std::uint32_t losses = 0;
};

inline constexpr std::uint32_t kFailuresAllowed = 1;
inline constexpr std::uint32_t kLossesAllowed = 20;

/// Whether the job gets another attempt after this outcome, and the counts from then on. Only a crash
/// and running out of memory count against an input; losses have a bound so that a job that kills its
/// server is parked at last.
struct Verdict {
  bool again = false;
  FailureCounts failure_counts;
  /// It gets none because its attempts are used up.
  bool parked = false;
};
Verdict judge(Outcome outcome, FailureCounts before);

/// job_not_found, in the words that everybody uses who does not find it, or must not say that there is one.
Error no_such_job(std::string_view id);

}  // namespace surfaced
