// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_protocol.hpp"

#include "platform/bounded_json.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxPhaseBytes = 64;
constexpr std::size_t kMaxDetailBytes = 4096;

/// Replaces what is no UTF-8: names and details may hold bytes of the input.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string encode(const AttemptSpec& spec) {
  return text_of({{"job", spec.claim.job},
                  {"attempt", spec.claim.attempt},
                  {"method", spec.method},
                  {"parameters", spec.parameters},
                  {"cloud", spec.cloud.string()},
                  {"cloud_sha256", spec.cloud_sha256},
                  {"directory", spec.directory.string()},
                  {"mesh", spec.mesh},
                  {"points", spec.points},
                  {"memory_bytes", spec.limits.memory_bytes},
                  {"max_points", spec.limits.max_points},
                  {"file_bytes", spec.limits.file_bytes},
                  {"seconds", spec.limits.time.count()},
                  {"threads", spec.limits.threads},
                  {"parent", spec.parent},
                  {"more_meshes", spec.more_meshes},
                  {"traceparent", spec.traceparent}});
}

Result<AttemptSpec> decode_attempt(std::string_view text) {
  try {
    const Json json = Json::parse(text);
    AttemptSpec spec;
    spec.claim = {json.at("job").get<std::string>(), json.at("attempt").get<std::uint32_t>()};
    spec.method = json.at("method").get<std::string>();
    spec.parameters = json.at("parameters");
    spec.cloud = json.at("cloud").get<std::string>();
    spec.cloud_sha256 = json.at("cloud_sha256").get<std::string>();
    spec.directory = json.at("directory").get<std::string>();
    spec.mesh = json.at("mesh").get<std::string>();
    spec.points = json.at("points").get<std::string>();
    spec.limits = {
        json.at("memory_bytes").get<std::uint64_t>(), json.at("max_points").get<std::uint64_t>(),
        json.at("file_bytes").get<std::uint64_t>(),   std::chrono::seconds(json.at("seconds").get<std::int64_t>()),
        json.at("threads").get<unsigned>(),           0};
    spec.parent = json.at("parent").get<int>();
    spec.more_meshes = json.at("more_meshes").get<std::vector<std::string>>();
    spec.traceparent = json.at("traceparent").get<std::string>();
    return spec;
  } catch (const Json::exception& wrong) {
    return Error{ErrorCode::invalid_usage, std::string("the server starts this command itself: ") + wrong.what()};
  }
}

std::string encode(const ProgressMessage& message) {
  return text_of({{"progress", message.progress}, {"phase", message.phase}}) + "\n";
}

std::string encode(const Error& problem) {
  return text_of({{"code", name_of(problem.code)}, {"detail", problem.detail.substr(0, kMaxDetailBytes)}}) + "\n";
}

Message decode_message(std::string_view line) {
  const auto read = parse_bounded(line);
  if (!read || !read->is_object()) return {};
  const Json& json = *read;
  const auto text = [&](const char* name, std::size_t limit) {
    const auto found = json.find(name);
    return found != json.end() && found->is_string() ? found->get<std::string>().substr(0, limit) : std::string();
  };
  if (const auto progress = json.find("progress"); progress != json.end() && progress->is_number()) {
    const auto fraction = progress->get<double>();
    if (!(fraction >= 0 && fraction <= 1)) return {};
    return ProgressMessage{fraction, text("phase", kMaxPhaseBytes)};
  }
  Error problem{ErrorCode::internal_error, text("detail", kMaxDetailBytes)};
  if (!error_code_named(text("code", kMaxPhaseBytes), problem.code)) return {};
  return problem;
}

}  // namespace surfaced
