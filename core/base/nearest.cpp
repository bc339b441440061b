// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/nearest.hpp"

#include <algorithm>
#include <vector>

#include "base/text.hpp"

namespace surfaced {
namespace {

constexpr std::size_t kLongest = 64;
constexpr std::size_t kLettersPerEdit = 3;

std::string lower(std::string_view text) {
  std::string plain = in_lower_case(text);
  std::ranges::replace(plain, '_', '-');
  return plain;
}

/// Optimal string alignment distance; three rows of the table are enough.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::string_view without_dashes(std::string_view name) {
  name.remove_prefix(std::min(name.find_first_not_of('-'), name.size()));
  return name;
}

/// Whether `name` has these words between its dashes, or begins with them.
bool has_word(std::string_view name, std::string_view words) {
  constexpr std::size_t kShortestWord = 3;
  if (words.size() < kShortestWord) return false;
  const std::string dashed = "-" + std::string(name) + "-";
  return dashed.find("-" + std::string(words) + "-") != std::string::npos || name.starts_with(words);
}

bool is_word(std::string_view text) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.';
  };
  return !text.empty() && std::ranges::all_of(text, fits);
}

/// The words of a list in words: `one of "y", "z" or an integer >= 8` lists y and z.
std::vector<std::string> words_of(std::string_view allowed) {
  constexpr std::string_view kOneOf = "one of ";
  std::vector<std::string> words;
  while (!allowed.empty()) {
    const std::size_t end = std::min({allowed.find(", "), allowed.find('|'), allowed.find(" or "), allowed.size()});
    std::string_view item = allowed.substr(0, end);
    allowed.remove_prefix(end);
    allowed.remove_prefix(std::min(allowed.size(), allowed.starts_with('|')      ? std::size_t{1}
                                                   : allowed.starts_with(" or ") ? 4
                                                                                 : 2));
    if (item.starts_with(kOneOf)) item.remove_prefix(kOneOf.size());
    if (item.size() > 2 && item.front() == '"' && item.back() == '"') item = item.substr(1, item.size() - 2);
    if (is_word(item)) words.emplace_back(item);
  }
  return words;
}

std::string without_quotes(std::string_view value) {
  if (value.size() > 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
  return std::string(value);
}

}  // namespace

std::string nearest_name(std::string_view written, std::span<const std::string> names) {
  if (written.empty() || written.size() > kLongest) return {};
  const std::string plain = lower(written);
  const std::string* best = nullptr;
  std::size_t fewest = plain.size() / kLettersPerEdit + 1;
  for (const std::string& name : names) {
    if (name.size() > kLongest) continue;
    const std::size_t distance = edits(plain, lower(name));
    if (distance >= std::min(fewest, std::max(plain.size(), name.size()))) continue;
    fewest = distance;
    best = &name;
  }
  if (best != nullptr) return *best;
  const auto holds = std::ranges::find_if(names, [&](const std::string& name) {
    const std::string whole = lower(name);
    return has_word(without_dashes(whole), without_dashes(plain));
  });
  return holds == names.end() ? std::string() : *holds;
}

std::string did_you_mean(std::string_view written, std::span<const std::string> names) {
  const std::string nearest = nearest_name(written, names);
  return nearest.empty() ? nearest : "Did you mean '" + nearest + "'?";
}

std::string did_you_mean(const Error& error) {
  if (!error.fault) return {};
  const std::vector<std::string> words = words_of(error.fault->allowed);
  std::string question = error.fault->value ? did_you_mean(without_quotes(*error.fault->value), words) : std::string();
  return question.empty() ? did_you_mean(error.fault->field, words) : question;
}

}  // namespace surfaced
