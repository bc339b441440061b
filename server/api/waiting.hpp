#pragma once

#include <chrono>
#include <functional>

#include "api/job_service.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// The answer to a request that waits for a job: what `show` makes of it as soon as it is `enough`, or when the time
/// is over.
http::Response when_enough(const http::Request& request, const std::string& id, std::chrono::milliseconds at_most,
                           JobService& service, std::function<bool(const Job&)> enough,
                           std::function<http::Response(const http::Request&, const Job&)> show);

}  // namespace surfaced::api
