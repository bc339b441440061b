// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/job_service.hpp"
#include "http/message.hpp"

namespace surfaced::api::ogc {

/// The results of a successful job as its request wanted them: one output as such, several as multipart/related, links
/// alone (204), or a document. What is large is sent from its file, in a document too.
http::Response results(const http::Request& request, const Job& job, JobService& service);

}  // namespace surfaced::api::ogc
