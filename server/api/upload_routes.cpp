// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/intake.hpp"
#include "api/routes.hpp"
#include "api/upload_headers.hpp"
#include "http/problem.hpp"
#include "platform/digest.hpp"
#include "platform/network.hpp"
#include "platform/space.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;
using Json = nlohmann::ordered_json;

constexpr const char* kVersion = "1.0.0";
constexpr const char* kExtensions = "creation,checksum,termination,expiration";
constexpr const char* kAlgorithms = "sha1,sha256,sha512,md5";
constexpr const char* kPatchType = "application/offset+octet-stream";

std::string upload_path(const std::string& id) { return "/v1/uploads/" + id; }

/// The endpoints of tus 1.0 (https://tus.io/protocols/resumable-upload): thin functions around UploadStore.
class Uploads {
 public:
  Uploads(JobService& service, UploadFinishing& finishing, std::uint64_t most_bytes)
      : service_(service), finishing_(finishing), store_(finishing.store()), most_bytes_(most_bytes) {}

  Response options(const Request& /*request*/) const {
    Response response = empty(204);
    response.headers.add("Tus-Version", kVersion);
    response.headers.add("Tus-Extension", kExtensions);
    response.headers.add("Tus-Checksum-Algorithm", kAlgorithms);
    response.headers.add("Tus-Max-Size", std::to_string(most_bytes_));
    return response;
  }

  Response create(const Request& request) {
    const auto upload = begin(request);
    if (!upload) return refuse(upload.error(), request);
    Response response = empty(201);
    response.headers.add("Location", upload_path(upload->id));
    add_state(*upload, response);
    return response;
  }

  Response head(const Request& request) {
    if (Status spoken = check_version(request); !spoken.ok()) return refuse(spoken.error(), request);
    const auto upload = find(request);
    if (!upload) return refuse(upload.error(), request);
    Response response = empty(200);
    add_state(*upload, response);
    response.headers.add("Upload-Length", std::to_string(upload->length));
    if (!upload->metadata.empty()) response.headers.add("Upload-Metadata", upload->metadata);
    return response;
  }

  Response get(const Request& request) {
    const auto upload = find(request);
    if (!upload) return refuse(upload.error(), request);
    return http::json_response(200, {{"id", upload->id},
                                     {"length", upload->length},
                                     {"offset", upload->offset},
                                     {"created_at", to_rfc3339(upload->created_at)},
                                     {"expires_at", to_rfc3339(upload->expires_at)},
                                     {"cloud_id", upload->cloud.empty() ? Json() : Json(upload->cloud)}});
  }

  Response patch(Request& request) {
    const auto upload = append(request);
    if (!upload) return refuse(upload.error(), request);
    Response response = empty(204);
    add_state(*upload, response);
    return response;
  }

  Response remove(const Request& request) {
    if (Status spoken = check_version(request); !spoken.ok()) return refuse(spoken.error(), request);
    if (const auto upload = find(request); !upload) return refuse(upload.error(), request);
    auto session = store_.begin(request.path_parts.at("id"));
    if (!session) return refuse(session.error(), request);
    const Status removed = session->remove();
    return removed ? empty(204) : refuse(removed.error(), request);
  }

 private:
  static Response empty(int status) {
    Response response;
    response.status = status;
    response.headers.add("Tus-Resumable", kVersion);
    response.headers.add("Cache-Control", "no-store");
    return response;
  }

  static Response refuse(const Error& error, const Request& request) {
    Response response = problem_response(error, request);
    response.headers.add("Tus-Resumable", kVersion);
    if (error.code == ErrorCode::unsupported_tus_version) response.headers.add("Tus-Version", kVersion);
    return response;
  }

  static void add_state(const PartialUpload& upload, Response& response) {
    response.headers.add("Upload-Offset", std::to_string(upload.offset));
    response.headers.add("Upload-Expires", to_http_date(upload.expires_at));
    if (!upload.cloud.empty()) response.headers.add("Surfaced-Cloud-Id", upload.cloud);
  }

  static Status check_version(const Request& request) {
    const auto version = request.headers.find("Tus-Resumable");
    if (version == kVersion) return Done{};
    return version ? http::wrong_value(ErrorCode::unsupported_tus_version, "Tus-Resumable", *version, kVersion)
                   : http::missing_value(ErrorCode::unsupported_tus_version, "Tus-Resumable", kVersion);
  }

  Result<PartialUpload> begin(const Request& request) {
    if (Status spoken = check_version(request); !spoken.ok()) return spoken.error();
    if (const auto concat = request.headers.find("Upload-Concat")) {
      return http::wrong_value(ErrorCode::invalid_request, "Upload-Concat", *concat,
                               "no such header: the extension concatenation is not among those of Tus-Extension");
    }
    if (const auto deferred = request.headers.find("Upload-Defer-Length")) {
      return http::wrong_value(ErrorCode::invalid_request, "Upload-Defer-Length", *deferred,
                               "no such header, but Upload-Length");
    }
    const auto length = bytes_header(request.headers, "Upload-Length");
    if (!length) return length.error();
    const std::string allowed = "1 to " + std::to_string(most_bytes_) + " bytes";
    if (*length == 0) return http::wrong_value(ErrorCode::empty_input, "Upload-Length", "0", allowed);
    if (*length > most_bytes_) {
      return http::wrong_value(ErrorCode::payload_too_large, "Upload-Length", std::to_string(*length), allowed);
    }
    const auto metadata = metadata_header(request.headers);
    if (!metadata) return metadata.error();
    if (Status space = service_.check_space(*length); !space.ok()) return space.error();
    const http::Caller& caller = request.caller;
    const std::string& address = request.remote_address;
    // On loopback there is a proxy, or nobody else.
    const std::string client = caller.id.empty() && !is_loopback(address) ? client_group(address) : caller.id;
    return store_.create({caller.id, client, allowance_of(caller)}, *length, *metadata);
  }

  /// The upload, if it is the caller's; another's does not exist for him.
  Result<PartialUpload> find(const Request& request) {
    const std::string& id = request.path_parts.at("id");
    auto upload = store_.find(id);
    const auto owner = request.caller.owner();
    if (!upload || !owner || upload->owner == *owner) return upload;
    return no_such_upload(id);
  }

  Result<PartialUpload> append(Request& request) {
    if (Status spoken = check_version(request); !spoken.ok()) return spoken.error();
    if (const std::string type = content_type_of(request); type != kPatchType) {
      return http::wrong_value(ErrorCode::unsupported_media_type, "Content-Type", type, kPatchType);
    }
    const auto offset = bytes_header(request.headers, "Upload-Offset");
    if (!offset) return offset.error();
    const auto checksum = checksum_header(request.headers);
    if (!checksum) return checksum.error();
    if (const auto upload = find(request); !upload) return upload;
    auto session = store_.begin(request.path_parts.at("id"));
    if (!session) return session.error();
    if (*offset != session->upload().offset) {
      return http::wrong_value(ErrorCode::upload_offset_mismatch, "Upload-Offset", std::to_string(*offset),
                               std::to_string(session->upload().offset) + ", where the upload ends");
    }
    if (Status space = service_.check_space(request.body->length().value_or(0)); !space.ok()) return space.error();
    auto upload = receive(request, *session, *checksum);
    if (!upload || !upload->whole()) return upload;
    return finishing_.finish(*session);
  }

  Result<PartialUpload> receive(Request& request, UploadStore::Session& session,
                                const std::optional<UploadChecksum>& checksum) {
    if (session.upload().whole()) return session.upload();
    auto digest = checksum ? Digest::named(checksum->algorithm) : std::nullopt;
    SpaceLooks space([this](std::uint64_t needed) { return service_.check_space(needed); });
    const Status read = request.body->read([&](std::span<const std::byte> bytes) {
      if (Status there = space.before(bytes.size()); !there.ok()) return there;
      if (digest) digest->update(bytes);
      return session.write(bytes);
    });
    // Of a part with a checksum nothing counts unless all of it is right.
    if (checksum) {
      if (!read) return read.error();
      if (digest->finish() != checksum->digest) {
        return with_fault(
            {ErrorCode::checksum_mismatch, "the " + checksum->algorithm +
                                               " of the part differs from Upload-Checksum; the upload still ends at " +
                                               std::to_string(session.upload().offset)},
            {"Upload-Checksum", std::string(request.headers.find("Upload-Checksum").value_or("")),
             "the " + checksum->algorithm + " of the bytes that are sent"});
      }
      return session.keep();
    }
    if (!read && read.error().code == ErrorCode::payload_too_large) return read.error();
    // What came before the connection broke off is kept: that is what resumable means.
    auto kept = session.keep();
    if (!read) return read.error();
    return kept;
  }

  JobService& service_;
  UploadFinishing& finishing_;
  UploadStore& store_;
  const std::uint64_t most_bytes_;
};

}  // namespace

void add_upload_routes(http::Router& router, JobService& service, UploadFinishing& finishing,
                       std::uint64_t most_bytes) {
  const auto uploads = std::make_shared<Uploads>(service, finishing, most_bytes);
  constexpr const char* kAll = "/v1/uploads";
  constexpr const char* kOne = "/v1/uploads/{id}";
  for (const char* const path : {kAll, kOne}) {
    router.add("OPTIONS", path, [uploads](Request& request) { return uploads->options(request); });
  }
  router.add("POST", kAll, [uploads](Request& request) { return uploads->create(request); });
  router.add("HEAD", kOne, [uploads](Request& request) { return uploads->head(request); });
  router.add("GET", kOne, [uploads](Request& request) { return uploads->get(request); });
  router.add("PATCH", kOne, [uploads](Request& request) { return uploads->patch(request); });
  router.add("DELETE", kOne, [uploads](Request& request) { return uploads->remove(request); });
}

}  // namespace surfaced::api
