// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/context.hpp"

#include <algorithm>
#include <utility>

namespace surfaced {
namespace {

/// Steps finer than this are not worth a call of the sink.
constexpr double kProgressStep = 1.0 / 512;

}  // namespace

Context::Context(unsigned threads, Sink sink, const std::atomic<bool>* cancel)
    : threads_(std::max(1U, threads)), sink_(std::move(sink)), cancel_(cancel), since_(Clock::now()) {}

void Context::close_stage() {
  const auto now = Clock::now();
  if (open_) stages_[current_].seconds += std::chrono::duration<double>(now - since_).count();
  since_ = now;
  open_ = false;
}

void Context::section(double until) {
  const std::scoped_lock lock(mutex_);
  section_from_ = std::max(last_, until_);
  section_until_ = std::clamp(until, section_from_, 1.0);
}

void Context::enter(std::string_view stage, double until) {
  const std::scoped_lock lock(mutex_);
  close_stage();
  const auto found = std::ranges::find(stages_, stage, &Stage::name);
  current_ = static_cast<std::size_t>(found - stages_.begin());
  if (found == stages_.end()) stages_.push_back({std::string(stage), 0});
  open_ = true;
  from_ = std::max(section_from_, until_);
  until_ = std::max(from_, section_from_ + std::clamp(until, 0.0, 1.0) * (section_until_ - section_from_));
  last_ = std::max(last_, from_);
  emit();
}

Status Context::begin(std::string_view stage, double until) {
  enter(stage, until);
  if (cancelled()) return Error{ErrorCode::cancelled, "cancelled at stage " + std::string(stage)};
  return Done{};
}

void Context::report(double fraction_of_stage) {
  const std::scoped_lock lock(mutex_);
  const double fraction = from_ + std::clamp(fraction_of_stage, 0.0, 1.0) * (until_ - from_);
  if (!open_ || fraction < last_ + kProgressStep) return;
  last_ = fraction;
  emit();
}

std::vector<Stage> Context::finish() {
  const std::scoped_lock lock(mutex_);
  close_stage();
  return stages_;
}

void Context::emit() {
  if (sink_) sink_(last_, stages_[current_].name);
}

}  // namespace surfaced
