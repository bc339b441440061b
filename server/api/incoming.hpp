// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "artifacts/artifact_store.hpp"
#include "http/message.hpp"
#include "jobs/job_store.hpp"

namespace surfaced::api {

/// What the caller may hold.
Allowance allowance_of(const http::Caller& caller);

/// Bytes that are on their way in, by owner, so that many bodies at once, with or without a length, stop where the
/// owner's allowance ends and not when all of them are stored. What was received whole is let go of before it is
/// stored: the store decides again, for good, in the transaction that adds it, and nothing is counted twice.
class Incoming {
 public:
  explicit Incoming(JobStore& jobs) : jobs_(jobs) {}
  Incoming(const Incoming&) = delete;
  Incoming& operator=(const Incoming&) = delete;

  /// The upload, its bytes counted as they come if the caller has a limit.
  /// @param needed  bytes that are known to come
  /// @return  quota_exceeded, here or from writing
  Result<std::unique_ptr<Upload>> count(std::unique_ptr<Upload> upload, const http::Caller& caller,
                                        std::uint64_t needed);

  /// A share of the count, given back when it is destroyed.
  class Share {
   public:
    Share(Incoming& incoming, std::string owner, const Allowance& allowance)
        : incoming_(incoming), owner_(std::move(owner)), allowance_(allowance) {}
    ~Share() { release(); }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    /// Makes it this large, if it is smaller; quota_exceeded.
    Status grow(std::uint64_t bytes);
    void release();

   private:
    Incoming& incoming_;
    const std::string owner_;
    const Allowance allowance_;
    std::uint64_t bytes_ = 0;
  };

 private:
  JobStore& jobs_;
  std::mutex mutex_;
  std::map<std::string, std::uint64_t> bytes_;
};

}  // namespace surfaced::api
