// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/waiting.hpp"

#include <memory>
#include <optional>

#include "http/problem.hpp"

namespace surfaced::api {

namespace {

struct Place {
  std::shared_ptr<http::Places> places;
  http::Places::Place place;
};

}  // namespace

Result<Seat> take_seat(const http::Request& request, const std::shared_ptr<http::Places>& places) {
  auto place = places->take(request.caller.id.empty() ? request.remote_address : request.caller.id);
  if (!place) return place.error();
  return Seat(std::make_shared<Place>(Place{places, std::move(*place)}));
}

http::Response when_enough(const http::Request& request, const std::string& id, std::chrono::milliseconds at_most,
                           JobService& service, std::function<bool(const Job&)> enough,
                           std::function<http::Response(const http::Request&, const Job&)> show, Seat seat) {
  http::Request asked = request;
  asked.body = nullptr;
  auto later = std::make_shared<http::Later>();
  later->deadline = std::chrono::steady_clock::now() + at_most;
  later->subscribe = [&service, id](std::function<void()> wake) { return service.watch(id, std::move(wake)); };
  later->look = [&service, id, asked = std::move(asked), enough = std::move(enough), show = std::move(show),
                 seat = std::move(seat)](bool last) -> std::optional<http::Response> {
    const auto job = service.find(id);
    if (!job) return http::problem_response(job.error(), asked);
    if (!last && !ended(job->status) && !enough(*job)) return std::nullopt;
    return show(asked, *job);
  };
  http::Response response;
  response.later = std::move(later);
  return response;
}

}  // namespace surfaced::api
