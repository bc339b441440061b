#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "base/base.hpp"

namespace surfaced::http {

/// The bodies that may be on their way at once: reading one holds a thread, and a client may take its time. What
/// is left of the threads stays free for everybody else.
class BodyPlaces {
 public:
  /// @param total        bodies at once
  /// @param per_address  bodies at once from one address; 0 for no limit. Loopback has none: there a proxy stands
  BodyPlaces(std::size_t total, std::size_t per_address) : total_(total), per_address_(per_address) {}
  BodyPlaces(const BodyPlaces&) = delete;
  BodyPlaces& operator=(const BodyPlaces&) = delete;

  class Place {
   public:
    Place(Place&& other) noexcept
        : places_(std::exchange(other.places_, nullptr)), address_(std::move(other.address_)) {}
    Place& operator=(Place&&) = delete;
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    ~Place() {
      if (places_ != nullptr) places_->leave(address_);
    }

   private:
    friend class BodyPlaces;
    Place(BodyPlaces* places, std::string address) : places_(places), address_(std::move(address)) {}
    BodyPlaces* places_;
    std::string address_;
  };

  /// @return  not_ready if all places are taken, too_many_requests if the address has all it may have
  Result<Place> take(const std::string& address);

 private:
  void leave(const std::string& address);

  const std::size_t total_;
  const std::size_t per_address_;
  std::mutex mutex_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_address_;
};

}  // namespace surfaced::http
