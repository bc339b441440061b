#include "jobs/job_events.hpp"

namespace surfaced {

JobEvents::Subscription::Subscription(JobEvents& events, std::string_view job) : events_(events), job_(job) {
  const std::scoped_lock lock(events_.mutex_);
  Topic& topic = events_.topics_[job_];
  ++topic.waiters;
  seen_ = topic.version;
}

JobEvents::Subscription::~Subscription() {
  const std::scoped_lock lock(events_.mutex_);
  const auto found = events_.topics_.find(job_);
  if (--found->second.waiters == 0) events_.topics_.erase(found);
}

bool JobEvents::Subscription::wait_until(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(events_.mutex_);
  Topic& topic = events_.topics_[job_];
  topic.changed.wait_until(lock, deadline, [&] { return topic.version != seen_ || events_.closed_; });
  if (topic.version == seen_) return false;
  seen_ = topic.version;
  return true;
}

void JobEvents::changed(std::string_view job) {
  const std::scoped_lock lock(mutex_);
  const auto found = topics_.find(std::string(job));
  if (found == topics_.end()) return;
  ++found->second.version;
  found->second.changed.notify_all();
}

void JobEvents::close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  for (auto& [job, topic] : topics_) topic.changed.notify_all();
}

}  // namespace surfaced
