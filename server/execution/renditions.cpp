// SPDX-License-Identifier: GPL-3.0-or-later
#include "execution/renditions.hpp"

#include <algorithm>

namespace surfaced {
namespace {

constexpr std::size_t kAtOnce = 2;
constexpr std::size_t kMostWaiting = 200;
constexpr std::size_t kMostOfOwner = 32;
/// Claims of attempts stay below.
constexpr std::uint32_t kFirstNumber = 0x8000'0000U;
constexpr const char* kReport = "report.json";
constexpr std::uint64_t kMaxReport = std::uint64_t{1} << 20;

const Output* output_of(const Job& job, std::string_view name) {
  const auto found = std::ranges::find(job.outputs, name, &Output::name);
  return found == job.outputs.end() ? nullptr : &*found;
}

/// The report for the mesh's extras; empty if the job has none.
Result<std::string> report_text(ArtifactStore& artifacts, const Job& job) {
  const Output* const report = output_of(job, kReport);
  if (report == nullptr) return std::string();
  const auto reader = artifacts.open_output({job.id, report->attempt}, kReport);
  if (!reader) return reader.error();
  const std::uint64_t size = (*reader)->size();
  if (size > kMaxReport) {
    return Error{ErrorCode::internal_error, "the report of job " + job.id + " has " + std::to_string(size) +
                                                " bytes, the limit is " + std::to_string(kMaxReport)};
  }
  std::string text(size, '\0');
  const auto count = (*reader)->read(0, std::as_writable_bytes(std::span(text)));
  if (!count) return count.error();
  if (*count == size) return text;
  return Error{ErrorCode::internal_error, "of the " + std::to_string(size) + " bytes of the report of job " + job.id +
                                              " only " + std::to_string(*count) + " can be read"};
}

std::string entry_of(const std::string& job, const std::string& name) { return job + "/" + name; }

/// True if a request waits for it, beside the table of orders and the queue.
bool awaited(const std::shared_ptr<Renditions::Order>& order) { return order.use_count() > 2; }

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
  if (Status room = make_room(job.owner); !room.ok()) return room.error();
  const auto order = std::make_shared<Order>(Order{job.id, name, number, job.owner, {}});
  orders_.emplace(entry, order);
  waiting_.push_back(order);
  changed_.notify_one();
  return std::shared_ptr<const Order>(order);
}

Status Renditions::make_room(const std::string& owner) {
  const auto of_owner = [&](const auto& order) { return order->owner == owner; };
  const auto count = [&] { return static_cast<std::size_t>(std::ranges::count_if(waiting_, of_owner)); };
  const auto owner_full = [&] { return !owner.empty() && count() >= kMostOfOwner; };
  if (waiting_.size() < kMostWaiting && !owner_full()) return Done{};
  std::erase_if(waiting_, [&](const auto& order) {
    if (awaited(order)) return false;
    orders_.erase(entry_of(order->job, order->name));
    return true;
  });
  if (owner_full()) {
    return Error{ErrorCode::too_many_requests, std::to_string(count()) +
                                                   " meshes of this key's jobs wait to be made in another format, the "
                                                   "limit is " +
                                                   std::to_string(kMostOfOwner)};
  }
  if (waiting_.size() < kMostWaiting) return Done{};
  return Error{ErrorCode::not_ready, std::to_string(waiting_.size()) +
                                         " meshes wait to be made in another format, the limit is " +
                                         std::to_string(kMostWaiting)};
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
  auto first = std::ranges::find_if(waiting_, awaited);
  if (first == waiting_.end()) first = waiting_.begin();
  auto order = std::move(*first);
  waiting_.erase(first);
  return order;
}

void Renditions::work() {
  while (const auto order = next()) {
    const std::string entry = entry_of(order->job, order->name);
    auto result = make_safely(*order);
    {
      const std::scoped_lock lock(mutex_);
      order->result.emplace(std::move(result));
      orders_.erase(entry);
    }
    events_.changed(entry);
  }
}

Result<Output> Renditions::make_safely(const Order& order) {
  try {
    return make(order);
  } catch (const std::exception& failure) {
    return Error{ErrorCode::internal_error, failure.what()};
  }
}

Result<Output> Renditions::make(const Order& order) {
  const auto& [id, name, number, owner, none] = order;
  const auto job = jobs_.find(id);
  if (!job) return job.error();
  if (const Output* const made = output_of(*job, name)) return *made;
  const Output* const kept = output_of(*job, kKeptMesh);
  const Output* const source = kept != nullptr ? kept : output_of(*job, job->wanted.front());
  if (source == nullptr) return Error{ErrorCode::internal_error, "job " + id + " has lost its mesh"};
  const auto file = artifacts_.output_file({id, source->attempt}, source->name);
  if (!file) return file.error();
  const auto report = report_text(artifacts_, *job);
  if (!report) return report.error();
  const Claim place{id, kFirstNumber + number};
  auto output = task_.run({place, *file, job->parameters, name, *report}, stop_);
  if (!output) return output;
  const auto added = jobs_.add_output({id, source->attempt}, *output);
  if (added && *added) return output;
  artifacts_.discard(place);
  if (!added) return added.error();
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
