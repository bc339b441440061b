// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "api/job_service.hpp"
#include "http/message.hpp"
#include "http/permits.hpp"

namespace surfaced::api {

/// A permit that is given back with the last copy; it may outlive the routes.
using HeldPermit = std::shared_ptr<const void>;

/// A permit for whoever asks: its key's, or its address's.
/// @return  as Permits::acquire
Result<HeldPermit> acquire_permit(const http::Request& request, const std::shared_ptr<http::Permits>& permits);

/// The answer to a request that waits for a job: what `show` makes of it as soon as it is `enough`, or when the time
/// is over.
/// @param permit  held while it waits
http::Response when_enough(const http::Request& request, const std::string& id, std::chrono::milliseconds at_most,
                           JobService& service, std::function<bool(const Job&)> enough,
                           std::function<http::Response(const http::Request&, const Job&)> show, HeldPermit permit);

}  // namespace surfaced::api
