// SPDX-License-Identifier: GPL-3.0-or-later
#include "clouds/inspector.hpp"

#include "observability/log.hpp"
#include "observability/survives.hpp"
#include "platform/bounded_json.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFactsFile = "cloud.json";
/// More than the child ever writes; it may have been taken over by its input.
constexpr std::uint64_t kMaxFacts = std::uint64_t{64} << 10;
/// Looking again without being told forgives a lost wake-up and a failure that passes.
constexpr std::chrono::seconds kPatience{30};

bool is_of_the_input(ErrorCode code) {
  switch (code) {
    case ErrorCode::internal_error:
    case ErrorCode::storage_full:
    case ErrorCode::input_unreadable:
    case ErrorCode::output_not_writable:
    case ErrorCode::cancelled:
    case ErrorCode::lost:
    case ErrorCode::not_ready:
      return false;
    default:
      return true;
  }
}

}  // namespace

void CloudInspector::start() {
  thread_ = std::thread([this] { work(); });
}

void CloudInspector::wake() {
  const std::scoped_lock lock(mutex_);
  woken_ = true;
  wake_.notify_all();
}

void CloudInspector::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    wake_.notify_all();
  }
  stop_.stop(Outcome::drained);
  if (thread_.joinable()) thread_.join();
}

void CloudInspector::work() {
  for (;;) {
    survives("have clouds read", [this] {
      while (inspect_next()) {
      }
    });
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, kPatience, [&] { return stopping_ || woken_; });
    woken_ = false;
    if (stopping_) return;
  }
}

bool CloudInspector::inspect_next() {
  if (stop_.why()) return false;
  const auto id = clouds_.next_to_inspect();
  if (!id || !id->has_value()) return false;
  const auto facts = inspect(**id);
  if (!facts && !is_of_the_input(facts.error().code)) {
    if (!stop_.why())
      log(LogLevel::error, "cannot have a cloud read", {{"cloud", **id}, {"detail", facts.error().detail}});
    return false;
  }
  return clouds_.inspected(**id, facts).ok();
}

Result<Json> CloudInspector::inspect(const std::string& id) {
  const auto file = artifacts_.input_file(id);
  if (!file) return file.error();
  const Claim place{id, 0};
  const auto output = task_.run({place, *file, Json::object(), kFactsFile, ""}, stop_);
  if (!output) return output.error();
  Json facts;
  const auto reader = artifacts_.open_output(place, kFactsFile);
  if (reader && (*reader)->size() <= kMaxFacts) {
    std::string text((*reader)->size(), '\0');
    const auto count = (*reader)->read(0, std::as_writable_bytes(std::span(text)));
    auto read = parse_bounded(text);
    if (read && count && *count == text.size()) facts = std::move(*read);
  }
  artifacts_.discard(place);
  if (facts.is_object()) return facts;
  return Error{ErrorCode::crashed, "the process that read the cloud left nothing that can be understood"};
}

}  // namespace surfaced
