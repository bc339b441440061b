// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/intake.hpp"

#include <algorithm>

#include "api/outputs.hpp"
#include "base/text.hpp"
#include "http/multipart.hpp"
#include "http/problem.hpp"
#include "http/request_head.hpp"
#include "platform/bounded_json.hpp"

namespace surfaced::api {
namespace {

using http::Request;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxJsonBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxFieldBytes = std::size_t{64} << 10;

Status check_encoding(const Request& request) {
  const auto encoding = request.headers.find("Content-Encoding");
  if (!encoding || http::same_name(*encoding, "identity")) return Done{};
  return http::wrong_value(ErrorCode::unsupported_content_encoding, "Content-Encoding", *encoding, "identity");
}

/// A cloud may be packed by gzip: it is stored as it comes, and unpacked by the child that reads it.
Status check_cloud_encoding(const Request& request) {
  const auto encoding = request.headers.find("Content-Encoding");
  const bool packed = encoding && (http::same_name(*encoding, "gzip") || http::same_name(*encoding, "x-gzip"));
  if (!encoding || packed || http::same_name(*encoding, "identity")) return Done{};
  return http::wrong_value(ErrorCode::unsupported_content_encoding, "Content-Encoding", *encoding, "gzip or identity");
}

Status check_present(const Request& request) {
  if (!request.body->present()) {
    return with_fault({ErrorCode::length_required, "the request has neither Content-Length nor Transfer-Encoding"},
                      {"Content-Length", std::nullopt, "the bytes of a body"});
  }
  if (request.body->length() == 0) return Error{ErrorCode::empty_input, "the body has 0 bytes"};
  return Done{};
}

/// Where the mesh is the answer and the query does not name its format, the Accept header does.
Status add_accepted(http::Query& query, const Request& request, Endpoint endpoint) {
  const auto accept = request.headers.find("Accept");
  const auto named = [](const auto& pair) { return pair.first == "output"; };
  if (endpoint != Endpoint::reconstruct || !accept || std::ranges::any_of(query, named)) return Done{};
  const auto mesh = negotiate_mesh(accept, {});
  if (!mesh) return mesh.error();
  query.emplace_back("output", mesh->substr(mesh->find('.') + 1));
  return Done{};
}

/// The fields and the file of a form, as they come.
class Form {
 public:
  Form(JobService& service, const http::Caller& caller) : service_(service), caller_(caller) {}

  Status begin(const http::Part& part) {
    if (!part.is_file && part.name != "cloud") {
      fields_.emplace_back(part.name, "");
      in_cloud_ = false;
      return Done{};
    }
    if (part.name != "cloud") {
      return with_fault(
          {ErrorCode::invalid_request, "the form has a file '" + part.name + "'; allowed is one file 'cloud'"},
          {part.name, "a file", "one file 'cloud'"});
    }
    if (cloud_) {
      return with_fault({ErrorCode::conflicting_input, "the form has the part 'cloud' twice"},
                        {"cloud", "a second file", "one file"});
    }
    auto upload = service_.begin_upload(caller_);
    if (!upload) return upload.error();
    cloud_ = std::move(*upload);
    in_cloud_ = true;
    return Done{};
  }

  Status data(std::span<const std::byte> bytes) {
    if (in_cloud_) return cloud_->write(bytes);
    auto& [name, value] = fields_.back();
    if (value.size() + bytes.size() > kMaxFieldBytes) {
      return Error{ErrorCode::payload_too_large,
                   "the form's field '" + name + "' has more than " + std::to_string(kMaxFieldBytes) + " bytes"};
    }
    value.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return Done{};
  }

  /// What was read, together with the query.
  Result<Intake> intake(const Request& request, Endpoint endpoint, const SubmissionRules& rules) && {
    http::Query query = request.query;
    std::string cloud_id;
    for (auto& [name, value] : fields_) {
      if (!http::is_utf8(name) || !http::is_utf8(value)) {
        return Error{ErrorCode::invalid_request, "a field of the form is no UTF-8"};
      }
      if (name == "cloud_id") {
        cloud_id = std::move(value);
      } else {
        query.emplace_back(std::move(name), std::move(value));
      }
    }
    if (cloud_ && !cloud_id.empty()) {
      return with_fault(
          {ErrorCode::conflicting_input, "the form has both a file 'cloud' and cloud_id '" + cloud_id + "'"},
          {"cloud_id", cloud_id, "either it or the file 'cloud'"});
    }
    if (!cloud_ && cloud_id.empty()) {
      return http::missing_value(ErrorCode::invalid_request, "cloud", "a file 'cloud', or a field 'cloud_id'");
    }
    if (cloud_ && cloud_->bytes() == 0) return Error{ErrorCode::empty_input, "the file 'cloud' has 0 bytes"};
    if (Status accepted = add_accepted(query, request, endpoint); !accepted.ok()) return accepted.error();
    auto submission = read_submission(query, endpoint, rules);
    if (!submission) return std::move(submission).error();
    submission->cloud_id = std::move(cloud_id);
    return Intake{std::move(*submission), std::move(cloud_)};
  }

 private:
  JobService& service_;
  const http::Caller& caller_;
  http::Query fields_;
  std::unique_ptr<Upload> cloud_;
  bool in_cloud_ = false;
};

Result<Intake> take_in_form(Request& request, Endpoint endpoint, const SubmissionRules& rules, JobService& service) {
  const auto boundary = http::multipart_boundary(request.headers.find("Content-Type").value_or(""));
  if (!boundary) return boundary.error();
  if (Status there = check_present(request); !there.ok()) return there.error();
  Form form(service, request.caller);
  http::MultipartReader reader(
      *boundary, {[&](const http::Part& part) { return form.begin(part); },
                  [&](std::span<const std::byte> bytes) { return form.data(bytes); }, [] { return Status(Done{}); }});
  const Status read = request.body->read([&](std::span<const std::byte> bytes) { return reader.feed(bytes); });
  if (!read) return read.error();
  if (Status whole = reader.finish(); !whole.ok()) return whole.error();
  return std::move(form).intake(request, endpoint, rules);
}

Result<Intake> take_in_json(Request& request, const SubmissionRules& rules) {
  if (!request.query.empty()) {
    const auto& [name, value] = request.query.front();
    return with_fault(
        {ErrorCode::invalid_request, "'" + name + "' stands in the query; beside a body of JSON nothing may"},
        {name, value, "the same as a member of the body"});
  }
  const auto body = receive_json(request, kMaxJsonBytes);
  if (!body) return body.error();
  auto submission = read_submission(*body, rules);
  if (!submission) return std::move(submission).error();
  if (submission->cloud_id.empty()) {
    return http::missing_value(ErrorCode::invalid_request, "cloud_id", "the id that POST /v1/clouds has given");
  }
  return Intake{std::move(*submission), nullptr};
}

}  // namespace

std::string content_type_of(const Request& request) {
  const std::string_view type = request.headers.find("Content-Type").value_or("");
  std::string essence(type.substr(0, type.find(';')));
  while (essence.ends_with(' ')) essence.pop_back();
  return in_lower_case(essence);
}

Result<Json> receive_json(Request& request, std::size_t most_bytes) {
  if (Status plain = check_encoding(request); !plain.ok()) return plain.error();
  if (Status there = check_present(request); !there.ok()) return there.error();
  std::string text;
  const Status read = request.body->read([&](std::span<const std::byte> bytes) -> Status {
    if (text.size() + bytes.size() > most_bytes) {
      return Error{ErrorCode::payload_too_large,
                   "the body has more than " + std::to_string(most_bytes) + " bytes, the limit for JSON"};
    }
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return Done{};
  });
  if (!read) return read.error();
  return parse_bounded(text);
}

Result<std::unique_ptr<Upload>> receive_raw(Request& request, JobService& service) {
  if (Status known = check_cloud_encoding(request); !known.ok()) return known.error();
  if (Status there = check_present(request); !there.ok()) return there.error();
  auto upload = service.begin_upload(request.caller, request.body->length().value_or(0));
  if (!upload) return upload;
  const Status read = request.body->read([&](std::span<const std::byte> bytes) { return (*upload)->write(bytes); });
  if (!read) return read.error();
  if ((*upload)->bytes() == 0) return Error{ErrorCode::empty_input, "the body has 0 bytes"};
  return upload;
}

Result<Intake> take_in(Request& request, Endpoint endpoint, const SubmissionRules& rules, JobService& service) {
  const std::string type = content_type_of(request);
  if (type == "multipart/form-data") {
    if (Status plain = check_encoding(request); !plain.ok()) return plain.error();
    return take_in_form(request, endpoint, rules, service);
  }
  if (type == "application/json" || type.ends_with("+json")) {
    if (endpoint == Endpoint::jobs) return take_in_json(request, rules);
    return http::wrong_value(ErrorCode::unsupported_media_type, "Content-Type", type,
                             "application/octet-stream for the raw bytes of a cloud, or multipart/form-data");
  }
  http::Query query = request.query;
  if (Status accepted = add_accepted(query, request, endpoint); !accepted.ok()) return accepted.error();
  auto submission = read_submission(query, endpoint, rules);
  if (!submission) return std::move(submission).error();
  auto cloud = receive_raw(request, service);
  if (!cloud) return std::move(cloud).error();
  return Intake{std::move(*submission), std::move(*cloud)};
}

}  // namespace surfaced::api
