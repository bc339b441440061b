// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace surfaced {

enum class LogLevel : std::uint8_t { debug, info, warning, error };
enum class LogFormat : std::uint8_t { text, json };

/// How the log looks from now on; text from `info` on until it is said. To be called before threads are started.
void set_up_log(LogFormat format, LogLevel least);

using LogFields = std::initializer_list<std::pair<std::string_view, nlohmann::json>>;

/// One line on standard error: as JSON an object with time, level, message and the fields; as text the same in a
/// row. Fields that are empty texts are left out. Names that are used: request_id, job, attempt, method, route,
/// status, seconds, trace_id. Never throws.
void log(LogLevel level, std::string_view message, LogFields fields = {}) noexcept;

/// The trace id in a W3C trace context; empty if there is none.
std::string trace_id_of(std::string_view traceparent);

}  // namespace surfaced
