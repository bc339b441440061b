#include "jobs/renditions.hpp"

#include <algorithm>

namespace surfaced {
namespace {

constexpr std::size_t kAtOnce = 2;
constexpr std::chrono::seconds kPatience{30};
/// Claims of attempts stay below.
constexpr std::uint32_t kFirstNumber = 0x8000'0000U;
constexpr const char* kReport = "report.json";
constexpr std::uint64_t kMaxReport = std::uint64_t{1} << 20;

const Output* output_of(const Job& job, std::string_view name) {
  const auto found = std::ranges::find(job.outputs, name, &Output::name);
  return found == job.outputs.end() ? nullptr : &*found;
}

/// The report for the mesh's extras; empty if it is not to be had.
std::string report_text(ArtifactStore& artifacts, const Job& job) {
  const Output* const report = output_of(job, kReport);
  if (report == nullptr) return {};
  const auto reader = artifacts.open_output({job.id, report->attempt}, kReport);
  if (!reader || (*reader)->size() > kMaxReport) return {};
  std::string text((*reader)->size(), '\0');
  const auto count = (*reader)->read(0, std::as_writable_bytes(std::span(text)));
  return count && *count == text.size() ? text : std::string();
}

}  // namespace

Result<Output> Renditions::make(const Job& job, const std::string& name, std::uint32_t number) {
  const std::string entry = job.id + "/" + name;
  {
    std::unique_lock lock(mutex_);
    const auto free = [&] { return stop_.why() || (running_.size() < kAtOnce && !running_.contains(entry)); };
    if (!changed_.wait_for(lock, kPatience, free) || stop_.why()) {
      return Error{ErrorCode::not_ready, "the server makes " + std::to_string(kAtOnce) +
                                             " other formats of meshes at once, and none of them has ended in " +
                                             std::to_string(kPatience.count()) + " s"};
    }
    running_.insert(entry);
  }
  auto output = make_alone(job.id, name, number);
  const std::scoped_lock lock(mutex_);
  running_.erase(entry);
  changed_.notify_all();
  return output;
}

Result<Output> Renditions::make_alone(const std::string& id, const std::string& name, std::uint32_t number) {
  const auto job = jobs_.find(id);
  if (!job) return job.error();
  if (const Output* const made = output_of(*job, name)) return *made;
  const Output* const source = output_of(*job, job->wanted.front());
  if (source == nullptr) return Error{ErrorCode::internal_error, "job " + id + " has lost its mesh"};
  const auto file = artifacts_.output_file({id, source->attempt}, source->name);
  if (!file) return file.error();
  const Claim place{id, kFirstNumber + number};
  auto output = task_.run({place, *file, job->parameters, name, report_text(artifacts_, *job)}, stop_);
  if (!output) return output;
  const auto kept = jobs_.add_output({id, source->attempt}, *output);
  if (kept && *kept) return output;
  artifacts_.discard(place);
  if (!kept) return kept.error();
  const auto now = jobs_.find(id);
  return now ? Error{ErrorCode::not_ready, "the outputs of job " + id + " changed meanwhile"} : now.error();
}

void Renditions::stop() {
  stop_.stop(Outcome::drained);
  const std::scoped_lock lock(mutex_);
  changed_.notify_all();
}

}  // namespace surfaced
