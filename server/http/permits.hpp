// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "base/base.hpp"

namespace surfaced::http {

/// Permits for what a client holds for as long as it likes: a body on its way (which holds a thread), a stream of
/// events (which holds a connection). Fewer than there are threads or connections, so that the rest stays free for
/// everybody else.
class Permits {
 public:
  /// @param what        is counted, in the plural and with its verb: "bodies are being received"
  /// @param total       at once
  /// @param per_client  at once for one client; 0 for no limit. Loopback has none: there a proxy stands
  Permits(std::string what, std::size_t total, std::size_t per_client)
      : what_(std::move(what)), total_(total), per_client_(per_client) {}
  Permits(const Permits&) = delete;
  Permits& operator=(const Permits&) = delete;

  class Permit {
   public:
    Permit(Permit&& other) noexcept
        : permits_(std::exchange(other.permits_, nullptr)), client_(std::move(other.client_)) {}
    Permit& operator=(Permit&&) = delete;
    Permit(const Permit&) = delete;
    Permit& operator=(const Permit&) = delete;
    ~Permit() {
      if (permits_ != nullptr) permits_->release(client_);
    }

   private:
    friend class Permits;
    Permit(Permits* permits, std::string client) : permits_(permits), client_(std::move(client)) {}
    Permits* permits_;
    std::string client_;
  };

  /// @param asking  the client's address (client_group in platform/network.hpp counts it with others), or the id of its
  /// key
  /// @return  not_ready if all permits are taken, too_many_requests if the client has all it may have
  Result<Permit> acquire(const std::string& asking);

 private:
  void release(const std::string& client);

  const std::string what_;
  const std::size_t total_;
  const std::size_t per_client_;
  std::mutex mutex_;
  std::size_t held_ = 0;
  std::map<std::string, std::size_t> by_client_;
};

}  // namespace surfaced::http
