// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/engine.hpp"

#include <utility>

#include "http/problem.hpp"
#include "http/request_body.hpp"
#include "http/response_writer.hpp"
#include "platform/random.hpp"

namespace surfaced::http {
namespace {

/// Moves the answer into the exchange, written but for streams, of which only the head is.
void put(Exchange& exchange, Response response, bool close) {
  exchange.status = response.status;
  exchange.bytes = write_response(response, exchange.request, close);
  if (response.streaming) exchange.after = After::close;
  if (exchange.request.method == "HEAD") return;
  exchange.streaming = std::move(response.streaming);
  auto* const body = std::get_if<BodyStream>(&response.body);
  if (body != nullptr && body->length > 0) exchange.stream = std::move(*body);
}

}  // namespace

Exchange Engine::exchange(Connection& connection, const Result<RequestHead>& head) const {
  const RequestHead nothing{"GET", {}, {}, {}, NoBody{}, true, false};
  const RequestHead& shown = head ? *head : nothing;
  Exchange exchange;
  exchange.began = std::chrono::steady_clock::now();
  Request& request = exchange.request;
  RequestBody body(connection, shown, {decoder_, body_limit_, permits_}, request.remote_address);
  request.method = shown.method;
  request.path = shown.path;
  request.headers = shown.headers;
  request.remote_address = connection.remote_address();
  request.request_id = random_hex<12>();
  request.body = &body;
  auto query = parse_query(shown.query);
  Response response;
  if (!head || !query) {
    response = problem_response(head ? query.error() : head.error(), request);
  } else {
    request.query = std::move(*query);
    response = router_.handle(request);
  }
  request.body = nullptr;
  if (connection.too_slow()) {
    // Who was too slow has nothing on its way that is worth waiting for.
    exchange.after = After::close;
  } else if (!head || !body.complete()) {
    exchange.after = After::drain;
  } else {
    exchange.after = shown.close ? After::close : After::keep;
  }
  exchange.deferred = response.deferred;
  if (!exchange.deferred) put(exchange, std::move(response), shown.close || !body.complete());
  return exchange;
}

void Engine::finish(Exchange& exchange, Response response) {
  exchange.deferred.reset();
  put(exchange, std::move(response), exchange.after != After::keep);
}

}  // namespace surfaced::http
