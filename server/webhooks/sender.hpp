// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "jobs/job_store.hpp"
#include "webhooks/delivery_store.hpp"

namespace surfaced {

struct WebhookOptions {
  /// Key of the signatures.
  std::string secret;
  /// Sends to private addresses too.
  bool private_too = false;
  /// Certificates that are trusted besides those of the system; empty for none.
  std::string certificates;
};

/// What the receiver checks: HMAC-SHA256 over id.timestamp.body, as `v1,` and base64.
std::string webhook_signature(std::string_view secret, std::string_view id, std::string_view timestamp,
                              std::string_view body);

/// When a delivery is tried again after so many attempts; none once it is given up.
std::optional<std::chrono::seconds> retry_after(std::uint32_t attempts);

/// Tells webhooks of the ends of jobs, one delivery after the other, in a thread of its own (libcurl).
class WebhookSender {
 public:
  /// @param describe  the job as the receiver gets it
  using Describe = std::function<std::string(const Job&)>;
  WebhookSender(DeliveryStore& deliveries, JobStore& jobs, WebhookOptions options, Describe describe);
  ~WebhookSender() { stop(); }
  WebhookSender(const WebhookSender&) = delete;
  WebhookSender& operator=(const WebhookSender&) = delete;

  void start();
  void stop();

 private:
  void work();
  void deliver(Delivery delivery);
  Result<int> post(const Delivery& delivery, const std::string& body) const;

  DeliveryStore& deliveries_;
  JobStore& jobs_;
  const WebhookOptions options_;
  const Describe describe_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace surfaced
