// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/waiting.hpp"

#include <memory>
#include <optional>

#include "http/problem.hpp"

namespace surfaced::api {

namespace {

struct Held {
  std::shared_ptr<http::Permits> permits;
  http::Permits::Permit permit;
};

}  // namespace

Result<HeldPermit> acquire_permit(const http::Request& request, const std::shared_ptr<http::Permits>& permits) {
  auto permit = permits->acquire(request.caller.id.empty() ? request.remote_address : request.caller.id);
  if (!permit) return permit.error();
  return HeldPermit(std::make_shared<Held>(Held{permits, std::move(*permit)}));
}

http::Response when_enough(const http::Request& request, const std::string& id, std::chrono::milliseconds at_most,
                           JobService& service, std::function<bool(const Job&)> enough,
                           std::function<http::Response(const http::Request&, const Job&)> show, HeldPermit permit) {
  http::Request asked = request;
  asked.body = nullptr;
  auto deferred = std::make_shared<http::DeferredResponse>();
  deferred->deadline = std::chrono::steady_clock::now() + at_most;
  deferred->subscribe = [&service, id](std::function<void()> wake) { return service.watch(id, std::move(wake)); };
  deferred->poll = [&service, id, asked = std::move(asked), enough = std::move(enough), show = std::move(show),
                    permit = std::move(permit)](bool last) -> std::optional<http::Response> {
    const auto job = service.find(id);
    if (!job) return http::problem_response(job.error(), asked);
    if (!last && !ended(job->status) && !enough(*job)) return std::nullopt;
    return show(asked, *job);
  };
  http::Response response;
  response.deferred = std::move(deferred);
  return response;
}

}  // namespace surfaced::api
