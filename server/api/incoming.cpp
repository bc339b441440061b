// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/incoming.hpp"

namespace surfaced::api {
namespace {

class CountedUpload final : public Upload {
 public:
  CountedUpload(std::unique_ptr<Upload> upload, std::unique_ptr<Incoming::Share> share)
      : upload_(std::move(upload)), share_(std::move(share)) {}

  Status write(std::span<const std::byte> bytes) override {
    if (Status may = share_->grow(upload_->bytes() + bytes.size()); !may.ok()) return may;
    return upload_->write(bytes);
  }
  std::uint64_t bytes() const override { return upload_->bytes(); }
  const std::string& sha256() override {
    // Nothing comes any more.
    share_->release();
    return upload_->sha256();
  }
  Result<StoredInput> commit(std::string_view key) override {
    share_->release();
    return upload_->commit(key);
  }

 private:
  std::unique_ptr<Upload> upload_;
  std::unique_ptr<Incoming::Share> share_;
};

}  // namespace

Allowance allowance_of(const http::Caller& caller) { return {caller.most_active_jobs, caller.most_stored_bytes}; }

Result<std::unique_ptr<Upload>> Incoming::count(std::unique_ptr<Upload> upload, const http::Caller& caller,
                                                std::uint64_t needed) {
  const Allowance allowance = allowance_of(caller);
  if (allowance.bytes == 0) return upload;
  auto share = std::make_unique<Share>(*this, caller.id, allowance);
  if (Status may = share->grow(needed); !may.ok()) return may.error();
  return std::unique_ptr<Upload>(std::make_unique<CountedUpload>(std::move(upload), std::move(share)));
}

Status Incoming::Share::grow(std::uint64_t bytes) {
  if (bytes <= bytes_) return Done{};
  const auto holding = incoming_.jobs_.holding_of(owner_);
  if (!holding) return holding.error();
  const std::scoped_lock lock(incoming_.mutex_);
  std::uint64_t& all = incoming_.bytes_[owner_];
  const Status may = allowance_.check(*holding, 0, all + (bytes - bytes_));
  if (may) {
    all += bytes - bytes_;
    bytes_ = bytes;
  } else if (all == 0) {
    incoming_.bytes_.erase(owner_);
  }
  return may;
}

void Incoming::Share::release() {
  const std::scoped_lock lock(incoming_.mutex_);
  const auto all = incoming_.bytes_.find(owner_);
  if (all == incoming_.bytes_.end()) return;
  all->second -= bytes_;
  bytes_ = 0;
  if (all->second == 0) incoming_.bytes_.erase(all);
}

}  // namespace surfaced::api
