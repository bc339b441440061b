// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "base/base.hpp"

namespace surfaced::http {

/// Places for what a client holds for as long as it likes: a body on its way (which holds a thread), a stream of
/// events (which holds a connection). Fewer than there are threads or connections, so that the rest stays free for
/// everybody else.
class Places {
 public:
  /// @param what        is counted, in the plural and with its verb: "bodies are being received"
  /// @param total       at once
  /// @param per_client  at once for one client; 0 for no limit. Loopback has none: there a proxy stands
  Places(std::string what, std::size_t total, std::size_t per_client)
      : what_(std::move(what)), total_(total), per_client_(per_client) {}
  Places(const Places&) = delete;
  Places& operator=(const Places&) = delete;

  class Place {
   public:
    Place(Place&& other) noexcept : places_(std::exchange(other.places_, nullptr)), client_(std::move(other.client_)) {}
    Place& operator=(Place&&) = delete;
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    ~Place() {
      if (places_ != nullptr) places_->leave(client_);
    }

   private:
    friend class Places;
    Place(Places* places, std::string client) : places_(places), client_(std::move(client)) {}
    Places* places_;
    std::string client_;
  };

  /// @param asking  the client's address (client_group in platform/network.hpp counts it with others), or the id of its
  /// key
  /// @return  not_ready if all places are taken, too_many_requests if the client has all it may have
  Result<Place> take(const std::string& asking);

 private:
  void leave(const std::string& client);

  const std::string what_;
  const std::size_t total_;
  const std::size_t per_client_;
  std::mutex mutex_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_client_;
};

}  // namespace surfaced::http
