#include "jobs/renditions.hpp"

#include <algorithm>

namespace surfaced {
namespace {

constexpr std::size_t kAtOnce = 2;
constexpr std::size_t kMostWaiting = 200;
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

std::string entry_of(const std::string& job, const std::string& name) { return job + "/" + name; }

}  // namespace

void Renditions::start() {
  for (std::size_t i = 0; i < kAtOnce; ++i) threads_.emplace_back([this] { work(); });
}

Result<std::shared_ptr<const Renditions::Order>> Renditions::order(const Job& job, const std::string& name,
                                                                   std::uint32_t number) {
  const std::scoped_lock lock(mutex_);
  if (stop_.why()) return Error{ErrorCode::not_ready, "the server is stopping"};
  const std::string entry = entry_of(job.id, name);
  const auto found = orders_.find(entry);
  if (found != orders_.end()) return std::shared_ptr<const Order>(found->second);
  if (waiting_.size() >= kMostWaiting) {
    return Error{ErrorCode::not_ready, std::to_string(waiting_.size()) +
                                           " meshes wait to be made in another format, the limit is " +
                                           std::to_string(kMostWaiting)};
  }
  const auto order = std::make_shared<Order>(Order{job.id, name, number, {}});
  orders_.emplace(entry, order);
  waiting_.push_back(order);
  changed_.notify_one();
  return std::shared_ptr<const Order>(order);
}

std::optional<Result<Output>> Renditions::made(const Order& order) {
  const std::scoped_lock lock(mutex_);
  return order.result;
}

std::shared_ptr<void> Renditions::watch(const Order& order, std::function<void()> wake) {
  return events_.subscribe(entry_of(order.job, order.name), std::move(wake));
}

std::shared_ptr<Renditions::Order> Renditions::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stop_.why() || !waiting_.empty(); });
  if (stop_.why()) return nullptr;
  auto order = std::move(waiting_.front());
  waiting_.pop_front();
  return order;
}

void Renditions::work() {
  while (const auto order = next()) {
    auto result = make(*order);
    const std::string entry = entry_of(order->job, order->name);
    {
      const std::scoped_lock lock(mutex_);
      order->result.emplace(std::move(result));
      orders_.erase(entry);
    }
    events_.changed(entry);
  }
}

Result<Output> Renditions::make(const Order& order) {
  const auto& [id, name, number, none] = order;
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
  {
    const std::scoped_lock lock(mutex_);
    stop_.stop(Outcome::drained);
    changed_.notify_all();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

}  // namespace surfaced
