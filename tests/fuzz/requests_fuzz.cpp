// SPDX-License-Identifier: GPL-3.0-or-later
// What the endpoints read besides clouds: forms, queries, the headers of tus, Accept, ids of events, conditions.
#include <array>
#include <string_view>

#include "api/event_stream.hpp"
#include "api/outputs.hpp"
#include "api/submission.hpp"
#include "api/upload_headers.hpp"
#include "fuzz/fuzz_input.hpp"
#include "http/accept.hpp"
#include "http/conditional.hpp"
#include "http/multipart.hpp"
#include "http/request_head.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

/// Reads the form in pieces of this size; what came out, or why it was refused.
std::string form(std::string_view body, std::size_t piece) {
  std::string seen;
  http::MultipartReader reader("B", {[&](const http::Part& part) {
                                       demand(!part.name.empty(), "a part has a name");
                                       seen += "[" + part.name + (part.is_file ? "!" : "");
                                       return Status(Done{});
                                     },
                                     [&](std::span<const std::byte> bytes) {
                                       seen.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                                       return Status(Done{});
                                     },
                                     [&] {
                                       seen += "]";
                                       return Status(Done{});
                                     }});
  for (std::size_t at = 0; at < body.size(); at += piece) {
    const Status fed = reader.feed(std::as_bytes(std::span(body.substr(at, piece))));
    if (!fed) return "refused";
  }
  return reader.finish() ? seen : "refused";
}

void read_headers(const std::string& text) {
  http::Headers headers;
  for (const char* name : {"Upload-Length", "Upload-Checksum", "Upload-Metadata", "Range", "If-None-Match"}) {
    headers.add(name, text);
  }
  [[maybe_unused]] const bool length = api::bytes_header(headers, "Upload-Length").ok();
  [[maybe_unused]] const bool checksum = api::checksum_header(headers).ok();
  [[maybe_unused]] const bool metadata = api::metadata_header(headers).ok();
  [[maybe_unused]] const bool modified = http::not_modified(headers, "\"x\"");
  if (const auto range = http::requested_range(headers, "\"x\"", 1000); range && *range) {
    demand((*range)->length > 0 && (*range)->offset + (*range)->length <= 1000, "a range lies within the output");
  }
  if (const auto position = api::read_event_id(text)) {
    const auto again = api::read_event_id(api::event_id(*position));
    demand(again && again->log == position->log && again->state == position->state, "an event's id is read as written");
  }
  const auto mesh = api::negotiate_mesh(text, std::array<std::string, 1>{"mesh.ply"});
  demand(!mesh || api::is_mesh(*mesh), "what is negotiated is a mesh");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string whole = form(text, size + 1);
  demand(form(text, 1) == whole && form(text, 7) == whole, "a form is read the same however it is cut");
  [[maybe_unused]] const bool boundary = http::multipart_boundary(text).ok();
  read_headers(text);
  const auto query = http::parse_query(text);
  if (!query) return 0;
  for (const api::Endpoint endpoint : {api::Endpoint::reconstruct, api::Endpoint::jobs}) {
    const auto submission = api::read_submission(*query, endpoint, {std::chrono::seconds(60), true});
    if (!submission) check_error(submission.error());
  }
  return 0;
}
