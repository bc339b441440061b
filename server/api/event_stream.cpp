// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/event_stream.hpp"

#include <array>
#include <charconv>

#include "api/job_json.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using Json = nlohmann::ordered_json;

/// What nobody says (a job that expires) is noticed after this time.
constexpr std::chrono::seconds kLongestLook{1};
constexpr std::string_view kDone = "done";
/// Proxies close streams on which nothing moves; most wait for 30 s or longer.
constexpr std::chrono::seconds kLongestSilence{10};

}  // namespace

JobLook::JobLook(JobService& service, std::string job) : service_(service), job_(std::move(job)) {
  subscription_ = service_.watch(job_, [this] { fresh_ = false; });
}

std::shared_ptr<const Result<Job>> JobLook::get() {
  const std::scoped_lock lock(mutex_);
  const auto time = std::chrono::steady_clock::now();
  // Marked before the store is asked: a change meanwhile makes it outdated again.
  if (!fresh_.exchange(true) || !seen_ || time - when_ > kLongestLook) {
    seen_ = std::make_shared<const Result<Job>>(service_.find(job_));
    when_ = time;
    log_.reset();
  }
  return seen_;
}

std::shared_ptr<const std::string> JobLook::log(const Job& job, std::uint64_t offset) {
  const std::scoped_lock lock(mutex_);
  if (log_ && log_attempt_ == job.attempt && log_offset_ == offset) return log_;
  auto text = std::make_shared<std::string>(kLogPiece, '\0');
  const auto count = service_.read_log(job, offset, std::as_writable_bytes(std::span(*text)));
  text->resize(count ? *count : 0);
  log_ = std::move(text);
  log_attempt_ = job.attempt;
  log_offset_ = offset;
  return log_;
}

std::shared_ptr<JobLook> JobLooks::at(const std::string& job) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(looks_, [](const auto& entry) { return entry.second.expired(); });
  auto& entry = looks_[job];
  auto look = entry.lock();
  if (!look) entry = look = std::make_shared<JobLook>(service_, job);
  return look;
}

std::string event_id(const EventPosition& position) {
  return std::to_string(position.attempt) + "." + std::to_string(position.log) + "." + position.state;
}

std::optional<EventPosition> read_event_id(std::string_view text) {
  EventPosition position;
  const char* const end = text.data() + text.size();
  const auto attempt = std::from_chars(text.data(), end, position.attempt);
  if (attempt.ec != std::errc() || attempt.ptr == end || *attempt.ptr != '.') return std::nullopt;
  const auto log = std::from_chars(attempt.ptr + 1, end, position.log);
  if (log.ec != std::errc() || log.ptr == end || *log.ptr != '.') return std::nullopt;
  position.state.assign(log.ptr + 1, end);
  if (!position.state.empty() && position.state != kDone && !job_status_named(position.state)) return std::nullopt;
  return position;
}

void EventStream::add(std::string& bytes, std::string_view event, const Json& data) const {
  // JSON on one line: no line break of the data can end an event.
  bytes.append("event: ").append(event).append("\nid: ").append(event_id(position_));
  bytes.append("\ndata: ").append(http::text_of(data)).append("\n\n");
}

void EventStream::add_state(std::string& bytes, const Job& job) {
  const std::string_view status = name_of(job.status);
  if (job.attempt != position_.attempt) {
    position_.attempt = job.attempt;
    position_.log = 0;
    progress_ = -1;
    position_.state.clear();
  }
  if (position_.state == status || position_.state == kDone) return;
  position_.state = status;
  add(bytes, "state", job_json(job));
}

void EventStream::add_progress(std::string& bytes, const Job& job) {
  // A job that is just ending may be read as running after its progress was forgotten: it never falls.
  if (job.status != JobStatus::running || job.progress < progress_) return;
  if (job.progress == progress_ && job.phase == phase_) return;
  progress_ = job.progress;
  phase_ = job.phase;
  add(bytes, "progress", {{"progress", job.progress}, {"phase", job.phase}, {"attempt", job.attempt}});
}

bool EventStream::add_log(std::string& bytes, const Job& job) {
  if (job.attempt == 0) return true;
  const auto chunk = look_->log(job, position_.log);
  std::string_view text = *chunk;
  const bool full = text.size() == JobLook::kLogPiece;
  // A line that is not complete yet waits for its end; one that is longer than a chunk is cut.
  const std::size_t end = text.rfind('\n');
  if (!ended(job.status) || full) text = text.substr(0, end == text.npos ? (full ? text.size() : 0) : end + 1);
  if (text.empty()) return true;
  position_.log += text.size();
  Json lines = Json::array();
  for (std::string_view left = text; !left.empty();) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(left.size(), line.size() + 1));
    lines.push_back(std::string(line));
  }
  add(bytes, "log", {{"attempt", job.attempt}, {"lines", std::move(lines)}});
  return !full;
}

http::StreamingResponse::Chunk EventStream::next() {
  http::StreamingResponse::Chunk chunk;
  const auto seen = look_->get();
  const Result<Job>& job = *seen;
  if (!job) {
    // Removed while somebody watched: the reason is all there is to say.
    position_.state = kDone;
    add(chunk.bytes, kDone, http::problem_json(job.error(), job_path(job_), ""));
    chunk.end = true;
    return chunk;
  }
  add_state(chunk.bytes, *job);
  add_progress(chunk.bytes, *job);
  const bool log_is_out = add_log(chunk.bytes, *job);
  chunk.more = !log_is_out;
  if (log_is_out && ended(job->status)) {
    position_.state = kDone;
    add(chunk.bytes, kDone, job_json(*job));
    chunk.end = true;
  }
  // A running job wakes its streams far more often than there is something to tell.
  const auto time = std::chrono::steady_clock::now();
  if (chunk.bytes.empty() && time - told_ > kLongestSilence) chunk.bytes = ": still here\n\n";
  if (!chunk.bytes.empty()) told_ = time;
  return chunk;
}

}  // namespace surfaced::api
