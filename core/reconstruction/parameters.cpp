// SPDX-License-Identifier: GPL-3.0-or-later
// Parameters against their JSON Schema. The schemas use the keywords type (number, integer, string,
// boolean), enum, const, oneOf, minimum, exclusiveMinimum, maximum, pattern with maxLength, and nothing else; examples
// are for readers.
#include <charconv>
#include <cmath>
#include <limits>
#include <regex>

#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

/// The value in the one form that stands for it: integers as integers wherever the schema takes them.
Json canonical(const Json& value) {
  if (!value.is_number_float()) return value;
  const double x = value.get<double>();
  constexpr double kExactIntegers = 9007199254740992.0;
  return x == std::floor(x) && std::abs(x) < kExactIntegers ? Json(static_cast<std::int64_t>(x)) : value;
}

/// What a schema allows, in words.
std::string allowed_by(const Json& schema) {
  if (schema.contains("oneOf")) {
    std::string text;
    for (const Json& option : schema.at("oneOf")) text += (text.empty() ? "" : " or ") + allowed_by(option);
    return text;
  }
  if (schema.contains("x-allowed")) return schema.at("x-allowed");
  if (schema.contains("const")) return schema.at("const").dump();
  if (schema.contains("enum")) {
    std::string text;
    for (const Json& value : schema.at("enum")) text += (text.empty() ? "" : ", ") + value.dump();
    return "one of " + text;
  }
  std::string text = schema.at("type") == "integer" ? "an integer" : "a " + schema.at("type").get<std::string>();
  if (schema.contains("minimum")) text += " >= " + canonical(schema.at("minimum")).dump();
  if (schema.contains("exclusiveMinimum")) text += " > " + canonical(schema.at("exclusiveMinimum")).dump();
  if (schema.contains("maximum"))
    text += (text.find('>') != std::string::npos ? " and <= " : " <= ") + canonical(schema.at("maximum")).dump();
  return text;
}

bool matches_number(const Json& schema, const Json& value) {
  if (!value.is_number()) return false;
  const double x = value.get<double>();
  if (!std::isfinite(x) || (schema.at("type") == "integer" && x != std::floor(x))) return false;
  if (schema.contains("minimum") && x < schema.at("minimum").get<double>()) return false;
  if (schema.contains("exclusiveMinimum") && x <= schema.at("exclusiveMinimum").get<double>()) return false;
  return !schema.contains("maximum") || x <= schema.at("maximum").get<double>();
}

/// A pattern is of the whole text here, and only of texts whose length is bounded.
bool matches_text(const Json& schema, const Json& value) {
  if (!value.is_string()) return false;
  const std::string& text = value.get_ref<const std::string&>();
  if (schema.contains("maxLength") && text.size() > schema.at("maxLength").get<std::size_t>()) return false;
  return !schema.contains("pattern") || std::regex_match(text, std::regex(schema.at("pattern").get<std::string>()));
}

bool matches(const Json& schema, const Json& value) {
  if (schema.contains("oneOf")) {
    for (const Json& option : schema.at("oneOf")) {
      if (matches(option, value)) return true;
    }
    return false;
  }
  if (schema.contains("const")) return value == schema.at("const");
  if (schema.contains("enum")) {
    for (const Json& option : schema.at("enum")) {
      if (value == option) return true;
    }
    return false;
  }
  if (schema.at("type") == "boolean") return value.is_boolean();
  if (schema.at("type") == "string") return matches_text(schema, value);
  return matches_number(schema, value);
}

/// Text as a number if all of it is one, as a boolean if it names one, else as a string.
Json value_from_text(const std::string& text) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, problem] = std::from_chars(text.data(), end, number);
  if (problem == std::errc{} && stop == end && std::isfinite(number)) {
    constexpr double kExactIntegers = 9007199254740992.0;  // 2^53
    if (number == std::floor(number) && std::abs(number) < kExactIntegers) return static_cast<std::int64_t>(number);
    return number;
  }
  if (text == "true" || text == "false") return text == "true";
  return text;
}

Error unknown_parameter(const MethodInfo& method, const std::string& given) {
  constexpr std::size_t kLongestName = 200;
  const std::string name = given.substr(0, kLongestName);
  std::string known;
  for (const auto& [each, schema] : method.parameters.at("properties").items())
    known += (known.empty() ? "" : ", ") + each;
  return with_fault({ErrorCode::unknown_parameter,
                     "method '" + method.id + "' has no parameter '" + name + "'; its parameters are: " + known},
                    {name, std::nullopt, "one of " + known});
}

}  // namespace

Result<Json> check_parameters(const MethodInfo& method, const Json& given) {
  const Json& properties = method.parameters.at("properties");
  if (!given.is_object()) {
    return with_fault(
        {ErrorCode::invalid_parameter, "parameters must be a JSON object, not " + std::string(given.type_name())},
        {"parameters", std::string(given.type_name()), "an object"});
  }
  for (const auto& [name, value] : given.items()) {
    if (!properties.contains(name)) return unknown_parameter(method, name);
    if (!matches(properties.at(name), value)) {
      constexpr std::size_t kLongestEcho = 200;
      const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, kLongestEcho);
      const std::string allowed = allowed_by(properties.at(name));
      return with_fault(
          {ErrorCode::invalid_parameter, "parameter '" + name + "' is " + text + "; allowed is " + allowed},
          {name, text, allowed});
    }
  }
  Json complete = Json::object();
  for (const auto& [name, schema] : properties.items()) {
    complete[name] = canonical(given.contains(name) ? given.at(name) : schema.at("default"));
  }
  return complete;
}

Result<Json> parameters_from_text(const MethodInfo& method,
                                  std::span<const std::pair<std::string, std::string>> given) {
  Json values = Json::object();
  for (const auto& [name, text] : given) {
    if (values.contains(name)) {
      return with_fault({ErrorCode::invalid_parameter, "parameter '" + name + "' is given twice"},
                        {name, text, "one value"});
    }
    values[name] = value_from_text(text);
  }
  return check_parameters(method, values);
}

}  // namespace surfaced
