// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/usage.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "base/nearest.hpp"
#include "base/text.hpp"
#include "command/problem.hpp"

namespace surfaced {
namespace {

constexpr const char* kJsonVariable = "SURFACED_JSON";

bool is_for_people(const CLI::App* command) { return !command->get_group().empty(); }

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* each : app.get_subcommands({})) {
    if (is_for_people(each)) names.push_back(each->get_name());
  }
  return names;
}

std::vector<std::string> flags_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* each : command.get_options()) {
    if (!each->get_positional()) names.push_back(each->get_name());
  }
  return names;
}

/// The command whose words these are, and the first word behind its name that names none where one is needed.
struct Place {
  const CLI::App* command;
  std::string called;
  std::string unknown;
};

Place place_of(const CLI::App& app, std::span<char* const> words) {
  Place place{&app, app.get_name(), {}};
  for (const char* const word : words) {
    if (place.command->get_subcommands({}).empty()) break;
    if (std::string_view(word).starts_with('-')) continue;
    const auto known = place.command->get_subcommands([](const CLI::App* each) { return is_for_people(each); });
    const auto next = std::ranges::find_if(known, [word](const CLI::App* each) { return each->get_name() == word; });
    if (next == known.end()) {
      place.unknown = word;
      break;
    }
    place.command = *next;
    place.called += " " + place.command->get_name();
  }
  return place;
}

/// "surfaced reconstruct CLOUD -o MESH [FLAG...]".
std::string call_of(const Place& place) {
  std::string call = place.called;
  for (const CLI::Option* each : place.command->get_options()) {
    if (!each->get_required() && !each->get_positional()) continue;
    const std::string name =
        each->get_positional() ? each->get_name(true) : each->get_name() + " " + each->get_type_name();
    call += each->get_required() ? " " + name : " [" + name + "]";
  }
  return "It is called " + call + " [FLAG...]; " + place.called + " --help explains it.";
}

int report_unknown_command(const Place& place) {
  const std::string known = joined(commands_of(*place.command));
  const std::string& word = place.unknown;
  return report_problem(
      with_fault({ErrorCode::invalid_usage,
                  (word.empty() ? "no command is given" : "'" + word + "' is no command") + "; there are: " + known},
                 {"command", word.empty() ? std::nullopt : std::optional(word), "one of " + known}));
}

/// The first of the words that no flag or place takes. The parser's message lists those behind its colon, in no order
/// to rely on.
std::string first_unexpected(const std::string& message, std::span<char* const> words) {
  const std::string listed = " " + message.substr(message.rfind(": ") + 2) + " ";
  const auto first = std::ranges::find_if(
      words, [&](const char* word) { return listed.find(" " + std::string(word) + " ") != std::string::npos; });
  return first == words.end() ? message : *first;
}

int report_unexpected(const Place& place, const std::string& word) {
  const std::string flag = word.substr(0, word.find('='));
  const bool is_flag = flag.starts_with('-');
  return report_problem(
      with_fault({ErrorCode::invalid_usage, place.called + (is_flag ? " has no flag '" : " takes no '") + flag + "'"},
                 {flag, std::nullopt, is_flag ? "one of " + joined(flags_of(*place.command)) : "what --help names"}),
      call_of(place));
}

/// What the option takes: of "TEXT:{mesh,cloud}" "one of mesh, cloud"; of "UINT:INT in [1 - 1024]" the range.
std::string allowed_of(const CLI::Option& option) {
  std::string type = option.get_type_name();
  type.erase(0, type.find(':') == std::string::npos ? 0 : type.find(':') + 1);
  if (!type.starts_with('{') || !type.ends_with('}')) return type.empty() ? "a value" : type;
  std::string list = "one of ";
  for (const char c : type.substr(1, type.size() - 2)) list += c == ',' ? std::string(", ") : std::string(1, c);
  return list;
}

/// A message "NAME: what is wrong", "NAME is required" or "Could not convert: NAME = VALUE" is about the option of that
/// name.
int report_wrong_option(const Place& place, const std::string& message) {
  constexpr std::string_view kConversion = "Could not convert: ";
  const std::string rest = message.substr(message.starts_with(kConversion) ? kConversion.size() : 0);
  const std::string name = rest.substr(0, std::min(rest.find(": "), rest.find(' ')));
  const CLI::Option* const option = place.command->get_option_no_throw(name);
  if (option == nullptr) {
    return report_problem(
        with_fault({ErrorCode::invalid_usage, message}, {place.called, std::nullopt, "what --help explains"}),
        call_of(place));
  }
  const auto& given = option->results();
  return report_problem(
      with_fault({ErrorCode::invalid_usage, message},
                 {name, given.empty() ? std::nullopt : std::optional(given.back()), allowed_of(*option)}),
      call_of(place));
}

/// The names in the folder of a path, as many as are looked at in a moment.
std::vector<std::string> names_beside(const std::filesystem::path& path) {
  constexpr std::size_t kMostNames = 10'000;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::vector<std::string> names;
  std::error_code failed;
  auto each = std::filesystem::directory_iterator(folder, failed);
  while (!failed && each != std::filesystem::directory_iterator() && names.size() < kMostNames) {
    names.push_back(each->path().filename().string());
    each.increment(failed);
  }
  std::ranges::sort(names);
  return names;
}

bool is_missing(const std::filesystem::path& path) {
  std::error_code failed;
  return !path.empty() && !std::filesystem::exists(path, failed);
}

}  // namespace

void add_json_flags(CLI::App& app) {
  if (app.get_option_no_throw("--json") == nullptr) {
    app.add_flag_callback(
           "--json", [] { set_problem_format(ProblemFormat::json); },
           "Errors as one line of JSON, as where standard error is no terminal")
        ->envname(kJsonVariable);
  }
  for (CLI::App* each : app.get_subcommands({})) {
    if (is_for_people(each)) add_json_flags(*each);
  }
}

bool asks_for_json(std::span<char* const> words) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): read before any thread is started, and nobody writes
  const char* const variable = std::getenv(kJsonVariable);
  const std::string_view value = variable == nullptr ? "" : variable;
  if (!value.empty() && value != "false" && value != "0") return true;
  return std::ranges::find(words, std::string_view("--json"),
                           [](const char* word) { return std::string_view(word); }) != words.end();
}

int report_usage(const CLI::App& app, const CLI::ParseError& wrong, std::span<char* const> words) {
  const Place place = place_of(app, words);
  const std::string message = wrong.what();
  const bool is_extra = dynamic_cast<const CLI::ExtrasError*>(&wrong) != nullptr;
  const bool wants_command = !place.command->get_subcommands({}).empty();
  // The parser misses the command before it sees that a flag is none.
  const bool is_flag = place.unknown.empty() && !words.empty() && std::string_view(words.back()).starts_with('-');
  if (wants_command && is_flag && place.command->get_option_no_throw(words.back()) == nullptr) {
    return report_unexpected(place, words.back());
  }
  if (wants_command && (!place.unknown.empty() || !is_extra)) return report_unknown_command(place);
  return is_extra ? report_unexpected(place, first_unexpected(message, words)) : report_wrong_option(place, message);
}

int report_file_problem(Error error, std::span<const GivenPath> inputs, const GivenPath& output) {
  if (error.code == ErrorCode::input_unreadable) {
    for (const auto& [argument, path] : inputs) {
      if (!is_missing(path)) continue;
      const std::string meant = did_you_mean(path.filename().string(), names_beside(path));
      return report_problem(with_fault(std::move(error), {argument, path.string(), "a file that this user can read"}),
                            meant);
    }
  }
  const std::filesystem::path folder = output.path.parent_path();
  if (error.code == ErrorCode::output_not_writable && is_missing(folder)) {
    return report_problem(
        with_fault(std::move(error), {output.argument, output.path.string(), "a path in a folder that exists"}),
        "Make the folder first: mkdir -p '" + folder.string() + "'");
  }
  return report_problem(error);
}

}  // namespace surfaced
