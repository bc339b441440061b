// SPDX-License-Identifier: GPL-3.0-or-later
#include "webhooks/sender.hpp"

#include <curl/curl.h>

#include <array>
#include <memory>

#include "observability/log.hpp"
#include "observability/survives.hpp"
#include "platform/base64.hpp"
#include "platform/digest.hpp"

namespace surfaced {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};
constexpr long kConnectMilliseconds = 5'000;
constexpr long kWholeMilliseconds = 15'000;
/// Bytes of an answer's body that are taken.
constexpr std::size_t kMostAnswer = std::size_t{64} << 10;
/// Between two attempts; after the last one the delivery is given up.
constexpr auto kPauses =
    std::to_array<std::chrono::seconds>({std::chrono::seconds(5), std::chrono::seconds(30), std::chrono::minutes(5),
                                         std::chrono::minutes(30), std::chrono::hours(2), std::chrono::hours(12)});

struct FreeHandle {
  void operator()(CURL* handle) const { ::curl_easy_cleanup(handle); }
};
struct FreeList {
  void operator()(curl_slist* list) const { ::curl_slist_free_all(list); }
};
using List = std::unique_ptr<curl_slist, FreeList>;

List with(List list, const std::string& entry) {
  curl_slist* const longer = ::curl_slist_append(list.get(), entry.c_str());
  if (longer == nullptr) throw std::bad_alloc();
  [[maybe_unused]] curl_slist* const same = list.release();
  return List(longer);
}

/// What the receiver writes is of no interest; that it ends is, so most of it is not taken.
std::size_t drop(char* /*bytes*/, std::size_t size, std::size_t count, void* taken) {
  auto& total = *static_cast<std::size_t*>(taken);
  total += size * count;
  return total > kMostAnswer ? 0 : size * count;
}

int end_if(void* stopping, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return *static_cast<const std::atomic<bool>*>(stopping) ? 1 : 0;
}

}  // namespace

std::string webhook_signature(std::string_view secret, std::string_view id, std::string_view timestamp,
                              std::string_view body) {
  std::string message;
  message.append(id).append(".").append(timestamp).append(".").append(body);
  return "v1," + base64_encode(hmac_sha256(secret, message));
}

namespace {

List signed_headers(const std::string& secret, const Delivery& delivery, const std::string& body) {
  const std::string timestamp =
      std::to_string(std::chrono::duration_cast<std::chrono::seconds>(delivery.tried_at->time_since_epoch()).count());
  List headers = with(nullptr, "Content-Type: application/json");
  headers = with(std::move(headers), "Webhook-Id: " + delivery.id);
  headers = with(std::move(headers), "Webhook-Timestamp: " + timestamp);
  return with(std::move(headers), "Webhook-Signature: " + webhook_signature(secret, delivery.id, timestamp, body));
}

}  // namespace

std::optional<std::chrono::seconds> retry_after(std::uint32_t attempts) {
  if (attempts == 0 || attempts > kPauses.size()) return std::nullopt;
  return kPauses.at(attempts - 1);
}

WebhookSender::WebhookSender(DeliveryStore& deliveries, JobStore& jobs, WebhookOptions options, Describe describe)
    : deliveries_(deliveries), jobs_(jobs), options_(std::move(options)), describe_(std::move(describe)) {}

void WebhookSender::start() {
  looking_ = std::thread([this] { look(); });
  for (std::size_t i = receivers_.room(); i > 0; --i) sending_.emplace_back([this] { work(); });
}

void WebhookSender::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    free_.notify_all();
    handed_.notify_all();
  }
  if (looking_.joinable()) looking_.join();
  for (std::thread& thread : sending_) thread.join();
  sending_.clear();
}

void WebhookSender::look() {
  while (!stopping_) {
    survives("look for webhooks that are due", [this] { hand_out(); });
    std::unique_lock lock(mutex_);
    free_.wait_for(lock, kBetweenLooks, [&] { return stopping_ || freed_; });
    freed_ = false;
  }
}

void WebhookSender::hand_out() {
  const std::size_t room = receivers_.room();
  if (room == 0) return;
  auto due = deliveries_.due(room, [&](const std::string& receiver) { return receivers_.is_free(receiver); });
  if (!due) {
    log(LogLevel::error, "cannot look for webhooks that are due", {{"detail", due.error().detail}});
    return;
  }
  const std::scoped_lock lock(mutex_);
  for (Delivery& delivery : *due) {
    queue_.push_back(delivery);
    receivers_.take(delivery.receiver);
    handed_.notify_one();
  }
}

void WebhookSender::work() {
  for (;;) {
    std::unique_lock lock(mutex_);
    handed_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
    if (stopping_) return;
    const Delivery delivery = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    if (!survives("tell of a job's end", [&] { deliver(delivery); })) {
      const Error failed{ErrorCode::internal_error, "the request could not be made"};
      survives("note that a delivery failed", [&] { note(delivery, failed, false); });
    }
    receivers_.leave(delivery.receiver);
    lock.lock();
    freed_ = true;
    free_.notify_one();
  }
}

void WebhookSender::deliver(Delivery delivery) {
  const auto job = jobs_.find(delivery.job);
  if (!job) {
    const ErrorCode why = job.error().code;
    note(std::move(delivery), job.error(), why == ErrorCode::job_not_found || why == ErrorCode::job_gone);
    return;
  }
  delivery.tried_at = now();
  const auto target = resolve_target(delivery.url, options_.private_too);
  // Others at this address are told first.
  if (target && !receivers_.settle(delivery.receiver, target->address)) return;
  const Result<int> answered = target ? post(delivery, *target, describe_(*job)) : Result<int>(target.error());
  note(std::move(delivery), answered, false);
}

void WebhookSender::note(Delivery delivery, const Result<int>& answered, bool job_is_gone) {
  if (!answered && stopping_) return;
  const SystemTime time = now();
  ++delivery.attempts;
  delivery.tried_at = time;
  delivery.http_status = answered ? *answered : 0;
  delivery.next_at.reset();
  if (answered && *answered >= 200 && *answered < 300) {
    delivery.status = "delivered";
    delivery.detail.clear();
  } else {
    delivery.detail = answered ? "the receiver answered " + std::to_string(*answered) : answered.error().detail;
    // A job that is gone has nothing to tell any more; 410 says that nobody listens.
    const auto pause = job_is_gone || delivery.http_status == 410 ? std::nullopt : retry_after(delivery.attempts);
    delivery.status = pause ? "pending" : "given_up";
    if (pause) delivery.next_at = time + *pause;
  }
  // If this cannot be noted the delivery is made again: at least once is what is promised.
  if (const Status noted = deliveries_.tried(delivery); !noted)
    log(LogLevel::error, "cannot note what became of a delivery", {{"detail", noted.error().detail}});
}

Result<int> WebhookSender::post(const Delivery& delivery, const WebhookTarget& target, const std::string& body) const {
  const std::unique_ptr<CURL, FreeHandle> handle(::curl_easy_init());
  if (!handle) throw std::bad_alloc();
  const List headers = signed_headers(options_.secret, delivery, body);
  const bool six = target.address.find(':') != std::string::npos;
  const List pinned =
      with(nullptr, target.host + ":" + target.port + ":" + (six ? "[" + target.address + "]" : target.address));
  std::size_t taken = 0;
  CURL* const curl = handle.get();
  ::curl_easy_setopt(curl, CURLOPT_URL, delivery.url.c_str());
  ::curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "https");
  ::curl_easy_setopt(curl, CURLOPT_RESOLVE, pinned.get());
  // A proxy of the environment would look the name up again, and reach what this machine may not.
  ::curl_easy_setopt(curl, CURLOPT_PROXY, "");
  ::curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
  ::curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  ::curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT_MS, kConnectMilliseconds);
  ::curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, kWholeMilliseconds);
  ::curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
  ::curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, &end_if);
  ::curl_easy_setopt(curl, CURLOPT_XFERINFODATA, &stopping_);
  ::curl_easy_setopt(curl, CURLOPT_USERAGENT, "surfaced");
  ::curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());
  ::curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
  ::curl_easy_setopt(curl, CURLOPT_POSTFIELDS, body.c_str());
  ::curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &drop);
  ::curl_easy_setopt(curl, CURLOPT_WRITEDATA, &taken);
  if (!options_.certificates.empty()) ::curl_easy_setopt(curl, CURLOPT_CAINFO, options_.certificates.c_str());
  const CURLcode code = ::curl_easy_perform(curl);
  // It has answered, and goes on with more than anybody reads.
  const bool cut_short = code == CURLE_WRITE_ERROR && taken > kMostAnswer;
  if (code != CURLE_OK && !cut_short) return Error{ErrorCode::internal_error, ::curl_easy_strerror(code)};
  long status = 0;
  ::curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
  return static_cast<int>(status);
}

}  // namespace surfaced
