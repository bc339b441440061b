// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/job_service.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// Who asks, with the trace context and the idempotency key that the request carries.
/// @return  invalid_request for an Idempotency-Key that is empty, longer than 255 characters or not printable.
Result<RequestContext> context_of(const http::Request& request);

}  // namespace surfaced::api
