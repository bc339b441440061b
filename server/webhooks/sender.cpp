// SPDX-License-Identifier: GPL-3.0-or-later
#include "webhooks/sender.hpp"

#include <curl/curl.h>

#include <array>
#include <iostream>
#include <memory>

#include "platform/base64.hpp"
#include "platform/digest.hpp"
#include "webhooks/address_guard.hpp"

namespace surfaced {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};
constexpr std::size_t kAtOnce = 16;
constexpr long kConnectMilliseconds = 5'000;
constexpr long kWholeMilliseconds = 15'000;
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

/// What the receiver writes is of no interest; that it ends is.
std::size_t drop(char* /*bytes*/, std::size_t size, std::size_t count, void* /*unused*/) { return size * count; }

}  // namespace

std::string webhook_signature(std::string_view secret, std::string_view id, std::string_view timestamp,
                              std::string_view body) {
  std::string message;
  message.append(id).append(".").append(timestamp).append(".").append(body);
  return "v1," + base64_encode(hmac_sha256(secret, message));
}

std::optional<std::chrono::seconds> retry_after(std::uint32_t attempts) {
  if (attempts == 0 || attempts > kPauses.size()) return std::nullopt;
  return kPauses.at(attempts - 1);
}

WebhookSender::WebhookSender(DeliveryStore& deliveries, JobStore& jobs, WebhookOptions options, Describe describe)
    : deliveries_(deliveries), jobs_(jobs), options_(std::move(options)), describe_(std::move(describe)) {}

void WebhookSender::start() {
  thread_ = std::thread([this] { work(); });
}

void WebhookSender::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    wake_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void WebhookSender::work() {
  for (;;) {
    if (auto due = deliveries_.due(kAtOnce)) {
      for (Delivery& delivery : *due) {
        {
          const std::scoped_lock lock(mutex_);
          if (stopping_) return;
        }
        deliver(std::move(delivery));
      }
    } else {
      std::cerr << "webhooks: " << due.error().detail << std::endl;
    }
    std::unique_lock lock(mutex_);
    if (wake_.wait_for(lock, kBetweenLooks, [&] { return stopping_; })) return;
  }
}

void WebhookSender::deliver(Delivery delivery) {
  const auto job = jobs_.find(delivery.job);
  const SystemTime time = now();
  ++delivery.attempts;
  delivery.tried_at = time;
  delivery.http_status = 0;
  delivery.next_at.reset();
  const auto answered = job ? post(delivery, describe_(*job)) : Result<int>(job.error());
  if (answered) delivery.http_status = *answered;
  if (answered && *answered >= 200 && *answered < 300) {
    delivery.status = "delivered";
    delivery.detail.clear();
  } else {
    delivery.detail = answered ? "the receiver answered " + std::to_string(*answered) : answered.error().detail;
    // A job that is gone has nothing to tell any more; 410 says that nobody listens.
    const auto pause = !job || delivery.http_status == 410 ? std::nullopt : retry_after(delivery.attempts);
    delivery.status = pause ? "pending" : "given_up";
    if (pause) delivery.next_at = time + *pause;
  }
  // If this cannot be noted the delivery is made again: at least once is what is promised.
  if (const Status noted = deliveries_.tried(delivery); !noted)
    std::cerr << "webhooks: " << noted.error().detail << std::endl;
}

Result<int> WebhookSender::post(const Delivery& delivery, const std::string& body) const {
  const auto target = resolve_target(delivery.url, options_.private_too);
  if (!target) return target.error();
  const std::unique_ptr<CURL, FreeHandle> handle(::curl_easy_init());
  if (!handle) throw std::bad_alloc();
  const std::string timestamp =
      std::to_string(std::chrono::duration_cast<std::chrono::seconds>(delivery.tried_at->time_since_epoch()).count());
  List headers = with(nullptr, "Content-Type: application/json");
  headers = with(std::move(headers), "Webhook-Id: " + delivery.id);
  headers = with(std::move(headers), "Webhook-Timestamp: " + timestamp);
  headers = with(std::move(headers),
                 "Webhook-Signature: " + webhook_signature(options_.secret, delivery.id, timestamp, body));
  const bool six = target->address.find(':') != std::string::npos;
  const List pinned =
      with(nullptr, target->host + ":" + target->port + ":" + (six ? "[" + target->address + "]" : target->address));
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
  ::curl_easy_setopt(curl, CURLOPT_USERAGENT, "surfaced");
  ::curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());
  ::curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
  ::curl_easy_setopt(curl, CURLOPT_POSTFIELDS, body.c_str());
  ::curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &drop);
  if (!options_.certificates.empty()) ::curl_easy_setopt(curl, CURLOPT_CAINFO, options_.certificates.c_str());
  const CURLcode code = ::curl_easy_perform(curl);
  if (code != CURLE_OK) return Error{ErrorCode::internal_error, ::curl_easy_strerror(code)};
  long status = 0;
  ::curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
  return static_cast<int>(status);
}

}  // namespace surfaced
