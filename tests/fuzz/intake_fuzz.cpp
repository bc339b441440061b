// SPDX-License-Identifier: GPL-3.0-or-later
// What a request asks for: JSON of submissions and executions, and the queries of lists.
#include "api/intake.hpp"
#include "api/ogc_json.hpp"
#include "api/paging.hpp"
#include "api/submission.hpp"
#include "fuzz/fuzz_input.hpp"
#include "http/request_head.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

class BytesBody final : public http::BodySource {
 public:
  explicit BytesBody(std::string_view bytes) : bytes_(bytes) {}
  bool present() const override { return true; }
  std::optional<std::uint64_t> length() const override { return bytes_.size(); }
  Status read(const Sink& sink) override { return sink(std::as_bytes(std::span(bytes_))); }

 private:
  std::string_view bytes_;
};

void check_fault(const Error& error) {
  check_error(error);
  if (!error.fault) return;
  // The name may be empty: `?=9`, {"": 9}.
  demand(!error.fault->allowed.empty(), "a fault says what is allowed");
  demand(error.fault->field.size() + error.fault->value.value_or("").size() < 4096, "what was given is echoed in part");
}

void read_lists(std::string_view text) {
  http::Request request;
  auto query = http::parse_query(text);
  if (!query) return;
  request.query = std::move(*query);
  for (const auto& page : {api::read_page(request), api::read_ogc_page(request)}) {
    if (!page) {
      check_fault(page.error());
      continue;
    }
    demand(page->limit >= 1 && page->limit <= 200, "a page has a bounded length");
    demand(!page->cursor || *page->cursor > 0, "a cursor is the number of a job");
  }
}

void read_bodies(std::string_view text) {
  http::Request request;
  BytesBody body(text);
  request.body = &body;
  const auto json = api::receive_json(request, std::size_t{1} << 20);
  if (!json) return check_fault(json.error());
  const auto submission = api::read_submission(*json, {std::chrono::seconds(60), true});
  if (!submission) check_fault(submission.error());
  if (submission) {
    demand(!submission->outputs.empty() && submission->labels.size() <= 16, "a submission keeps to its bounds");
    demand(submission->ttl >= std::chrono::seconds(60), "a time to live keeps to its bounds");
  }
  const auto execution = api::ogc::read_execution(*json, methods().front());
  if (!execution) return check_fault(execution.error());
  Job job;
  job.presentation = api::ogc::text_of(execution->presentation);
  const auto again = api::ogc::presentation_of(job);
  demand(again.raw == execution->presentation.raw && again.outputs.size() == execution->presentation.outputs.size(),
         "what is kept with a job is read as written");
  [[maybe_unused]] const bool submitted = api::read_submission(execution->submission, {}).ok();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  read_lists(text);
  read_bodies(text);
  return 0;
}
