// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/problem.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>

#include "base/nearest.hpp"
#include "config/configuration.hpp"
#include "proto/embedded.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

std::optional<ProblemFormat>& asked_format() {
  static std::optional<ProblemFormat> asked;
  return asked;
}

ProblemFormat problem_format() {
  return asked_format().value_or(::isatty(STDERR_FILENO) != 0 ? ProblemFormat::text : ProblemFormat::json);
}

/// The rows stand in the order of ErrorCode, which is made from the same file.
Json row_of(ErrorCode code) {
  return Json::parse(proto::errors_json()).at("errors").at(static_cast<std::size_t>(code));
}

/// How the setting at fault is written; empty if it is none.
std::string hint_of_setting(const Error& error) {
  if (error.code != ErrorCode::invalid_usage || !error.fault) return {};
  const auto setting = std::ranges::find(setting_table(), error.fault->field, &Setting::name);
  if (setting == setting_table().end()) return {};
  const std::string examples(examples_of(setting->unit));
  return (examples.empty() ? "" : "It is written like " + examples + ". ") +
         "surfaced check-config shows every setting and its range.";
}

/// Some hints of errors.json speak of paths of HTTP; those have another one for the command.
std::string hint_for_command(const Error& error, const std::string& given) {
  const Json row = row_of(error.code);
  std::string hint = given.empty() ? hint_of_setting(error) : given;
  if (hint.empty()) hint = row.value("command_hint", row.at("hint").get<std::string>());
  const std::string meant = did_you_mean(error);
  return meant.empty() ? hint : meant + " " + hint;
}

/// Without what could write elsewhere on the terminal: control characters, of ASCII and of U+0080 to U+009F.
std::string harmless(std::string word) {
  for (std::size_t i = 0; i < word.size(); ++i) {
    const auto c = static_cast<unsigned char>(word[i]);
    const auto next = static_cast<unsigned char>(i + 1 < word.size() ? word[i + 1] : 0);
    if (c < 0x20 || c == 0x7F) word[i] = '?';
    if (c == 0xC2 && next >= 0x80 && next <= 0x9F) word[i] = word[i + 1] = '?';
  }
  return word;
}

/// A line of the text, later lines of it under the first.
void print_line(const char* name, std::string_view text) {
  constexpr std::size_t kWidth = 100;
  constexpr const char* kIndent = "            ";
  std::string line;
  std::string label = std::string("  ") + name;
  label.resize(std::char_traits<char>::length(kIndent), ' ');
  std::istringstream words{std::string(text)};
  for (std::string word; words >> word;) {
    word = harmless(std::move(word));
    if (!line.empty() && line.size() + word.size() >= kWidth) {
      std::cerr << label << line << "\n";
      line.clear();
      label = kIndent;
    }
    line += (line.empty() ? "" : " ") + word;
  }
  std::cerr << label << line << "\n";
}

void print_text(const Error& error, const std::string& hint) {
  std::cerr << "surfaced: " << row_of(error.code).at("title").get<std::string>() << "\n";
  print_line("what", error.detail);
  if (error.fault) {
    print_line("where", error.fault->field);
    if (error.fault->value) print_line("value", *error.fault->value);
    print_line("allowed", error.fault->allowed);
  }
  print_line("hint", hint_for_command(error, hint));
  print_line("code", std::string(name_of(error.code)) + ", exit " + std::to_string(exit_code_of(error.code)));
}

void print_json(const Error& error, const std::string& hint) {
  Json problem{{"code", name_of(error.code)},
               {"title", row_of(error.code).at("title")},
               {"detail", error.detail},
               {"hint", hint_for_command(error, hint)}};
  if (error.fault) {
    problem["field"] = error.fault->field;
    problem["value"] = error.fault->value ? Json(*error.fault->value) : Json();
    problem["allowed"] = error.fault->allowed;
  }
  std::cerr << problem.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace

void set_problem_format(ProblemFormat format) { asked_format() = format; }

int report_problem(const Error& error, const std::string& hint) {
  problem_format() == ProblemFormat::text ? print_text(error, hint) : print_json(error, hint);
  return exit_code_of(error.code);
}

int report_problems(std::span<const Error> errors) {
  const Error& first = errors.front();
  if (errors.size() == 1) return report_problem(first);
  if (problem_format() == ProblemFormat::json) {
    print_json({first.code, details_of(errors)}, {});
  } else {
    for (const Error& each : errors) print_text(each, {});
  }
  return exit_code_of(first.code);
}

}  // namespace surfaced
