// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "jobs/job_store.hpp"
#include "webhooks/address_guard.hpp"
#include "webhooks/delivery_store.hpp"
#include "webhooks/receivers.hpp"

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

/// Tells webhooks of the ends of jobs (libcurl): one thread looks for deliveries whose time has come and hands them to
/// some that send; each receiver gets one at a time (receivers.hpp), and those for others overtake.
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
  void look();
  /// Hands on what is due and whose receiver is free.
  void hand_out();
  void work();
  void deliver(Delivery delivery);
  /// What became of it, unless the server stops: then it is made again at the next start.
  void note(Delivery delivery, const Result<int>& answered, bool job_is_gone);
  Result<int> post(const Delivery& delivery, const WebhookTarget& target, const std::string& body) const;

  DeliveryStore& deliveries_;
  JobStore& jobs_;
  const WebhookOptions options_;
  const Describe describe_;
  Receivers receivers_{Receivers::Limits{}};
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  /// For the one that looks: a receiver is free again.
  std::condition_variable free_;
  bool freed_ = false;
  /// For those that send.
  std::condition_variable handed_;
  std::deque<Delivery> queue_;
  std::thread looking_;
  std::vector<std::thread> sending_;
};

}  // namespace surfaced
