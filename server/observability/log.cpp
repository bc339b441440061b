// SPDX-License-Identifier: GPL-3.0-or-later
#include "observability/log.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <exception>
#include <memory>

#include "observability/survives.hpp"
#include "platform/clock.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

std::atomic<LogFormat> chosen_format{LogFormat::text};

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return spdlog::level::debug;
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      return spdlog::level::warn;
    default:
      return spdlog::level::err;
  }
}

std::string_view name_of(LogLevel level) {
  constexpr std::string_view kNames[] = {"debug", "info", "warning", "error"};
  return kNames[static_cast<std::size_t>(level)];
}

spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> kLogger = [] {
    auto made = std::make_shared<spdlog::logger>("surfaced", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    // The line is made here; spdlog gates it by level and writes it whole.
    made->set_pattern("%v");
    made->set_level(spdlog::level::info);
    made->flush_on(spdlog::level::debug);
    return made;
  }();
  return *kLogger;
}

bool empty_text(const nlohmann::json& value) {
  return value.is_string() && value.get_ref<const std::string&>().empty();
}

std::string text_of(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string as_json(LogLevel level, std::string_view message, LogFields fields) {
  Json line{{"time", to_rfc3339(now())}, {"level", name_of(level)}, {"message", message}};
  for (const auto& [name, value] : fields) {
    if (!empty_text(value)) line[std::string(name)] = value;
  }
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string as_text(LogLevel level, std::string_view message, LogFields fields) {
  std::string line = to_rfc3339(now()) + " " + std::string(name_of(level)) + " " + std::string(message);
  for (const auto& [name, value] : fields) {
    if (empty_text(value)) continue;
    line.append(" ").append(name).append("=").append(text_of(value));
  }
  return line;
}

}  // namespace

void set_up_log(LogFormat format, LogLevel least) {
  chosen_format = format;
  logger().set_level(level_of(least));
}

void log(LogLevel level, std::string_view message, LogFields fields) noexcept {
  try {
    if (!logger().should_log(level_of(level))) return;
    const bool json = chosen_format == LogFormat::json;
    logger().log(level_of(level), json ? as_json(level, message, fields) : as_text(level, message, fields));
  } catch (const std::exception&) {
    // Memory or the disk ran out; there is no place left to say so.
  }
}

void log_failure(std::string_view doing, const std::exception& failure) noexcept {
  try {
    log(LogLevel::error, "cannot " + std::string(doing), {{"detail", failure.what()}});
  } catch (const std::exception&) {
    // As above.
  }
}

std::string trace_id_of(std::string_view traceparent) {
  constexpr std::size_t kBegin = 3;
  constexpr std::size_t kLength = 32;
  return traceparent.size() < kBegin + kLength ? std::string() : std::string(traceparent.substr(kBegin, kLength));
}

}  // namespace surfaced
