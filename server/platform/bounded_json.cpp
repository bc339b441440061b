// SPDX-License-Identifier: GPL-3.0-or-later
#include "platform/bounded_json.hpp"

#include <optional>
#include <string>
#include <vector>

namespace surfaced {
namespace {

Error refuse(const std::string& what) { return {ErrorCode::invalid_request, "the JSON " + what}; }

/// Counts what a parser would build, by brackets and commas outside of strings; whether the text is JSON is not its
/// matter.
class Census {
 public:
  explicit Census(const JsonBounds& bounds) : bounds_(bounds) {}

  std::optional<Error> of(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '"') {
        i = end_of_string(text, i);
      } else if (auto error = count(text[i])) {
        return error;
      }
    }
    return std::nullopt;
  }

 private:
  struct Level {
    bool object = false;
    std::size_t entries = 1;
  };

  static std::size_t end_of_string(std::string_view text, std::size_t begin) {
    for (std::size_t i = begin + 1; i < text.size(); ++i) {
      if (text[i] == '\\')
        ++i;
      else if (text[i] == '"')
        return i;
    }
    return text.size();
  }

  std::optional<Error> count(char mark) {
    if (mark == '[' || mark == '{') {
      if (levels_.size() == bounds_.depth) return refuse("is nested deeper than " + std::to_string(bounds_.depth));
      levels_.push_back({mark == '{'});
      ++values_;
    } else if (mark == ']' || mark == '}') {
      if (!levels_.empty()) levels_.pop_back();
    } else if (mark == ',' && !levels_.empty()) {
      Level& level = levels_.back();
      if (++level.entries > bounds_.members && level.object) {
        return refuse("has an object with more than " + std::to_string(bounds_.members) + " members");
      }
      ++values_;
    }
    if (values_ <= bounds_.values) return std::nullopt;
    return refuse("has more than " + std::to_string(bounds_.values) + " values");
  }

  const JsonBounds bounds_;
  std::vector<Level> levels_;
  std::size_t values_ = 1;
};

}  // namespace

Result<nlohmann::ordered_json> parse_bounded(std::string_view text, const JsonBounds& bounds) {
  if (auto error = Census(bounds).of(text)) return std::move(*error);
  try {
    return nlohmann::ordered_json::parse(text);
  } catch (const nlohmann::ordered_json::parse_error& wrong) {
    return Error{ErrorCode::invalid_request,
                 "the body is no JSON: it goes wrong at byte " + std::to_string(wrong.byte)};
  } catch (const nlohmann::ordered_json::out_of_range&) {
    return refuse("has a number that is beyond the range of float64");
  }
}

}  // namespace surfaced
