// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/keys.hpp"

#include <iostream>

#include "base/text.hpp"
#include "command/command.hpp"
#include "command/problem.hpp"
#include "config/units.hpp"

namespace surfaced {
namespace {

struct KeyOptions {
  std::filesystem::path file;
  std::string name;
  std::string scopes = "read,submit";
  std::string id;
  Quota quota;
};

/// The keys of the file; none if it does not exist yet.
Result<KeyRing> load_or_none(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return KeyRing();
  return KeyRing::load(file);
}

int add_key(const KeyOptions& options) {
  const auto scopes = scopes_named(options.scopes);
  if (!scopes) return report_problem(scopes.error());
  auto ring = load_or_none(options.file);
  if (!ring) return report_problem(ring.error());
  const std::string text = ring->add(options.name, *scopes, options.quota);
  const Status saved = ring->save(options.file);
  if (!saved) return report_problem(saved.error());
  std::cout << text << "\n";
  return 0;
}

int list_keys(const KeyOptions& options) {
  const auto ring = KeyRing::load(options.file);
  if (!ring) return report_problem(ring.error());
  for (const auto& [id, key] : ring->all()) {
    std::cout << id;
    for (const std::string& scope : names_of(key.scopes)) std::cout << " " << scope;
    std::cout << " " << key.created_at << " " << key.name << "\n";
  }
  return 0;
}

int remove_key(const KeyOptions& options) {
  auto ring = KeyRing::load(options.file);
  if (!ring) return report_problem(ring.error());
  if (!ring->remove(options.id)) {
    const std::string ids = joined(ring->all(), ", ", [](const auto& row) { return row.first; });
    return report_problem(
        with_fault({ErrorCode::invalid_usage, "'" + options.file.string() + "' has no key '" + options.id + "'"},
                   {"ID", options.id, ids.empty() ? "none: the file has no keys" : "one of " + ids}),
        "surfaced keys list " + options.file.string() + " shows them.");
  }
  const Status saved = ring->save(options.file);
  return saved ? 0 : report_problem(saved.error());
}

}  // namespace

void add_keys(CLI::App& app, Run& run) {
  auto options = std::make_shared<KeyOptions>();
  CLI::App* command = app.add_subcommand("keys", "Keys of the service: add, list, remove");
  command->require_subcommand(1);
  const auto add_verb = [&](const char* name, const char* text, int (*work)(const KeyOptions&)) {
    CLI::App* verb = command->add_subcommand(name, text);
    verb->add_option("FILE", options->file, "The file that `serve --keys` reads")->required();
    verb->callback([options, work, &run] { run = [options, work] { return work(*options); }; });
    return verb;
  };
  CLI::App* add = add_verb("add", "Make a key; its text is shown once", add_key);
  add->add_option("--name", options->name, "For people")->required();
  add->add_option("--scopes", options->scopes, "Of read, submit, metrics (nothing but /metrics), admin (all of them)")
      ->capture_default_str();
  add->add_option("--requests-per-minute", options->quota.requests_per_minute, "0: no limit")->capture_default_str();
  add->add_option("--submissions-per-minute", options->quota.submissions_per_minute,
                  "Clouds, uploads and jobs that are sent; 0: no limit")
      ->capture_default_str();
  add->add_option("--active-jobs", options->quota.active_jobs, "Jobs that wait or run; 0: no limit")
      ->capture_default_str();
  add->add_option("--stored-bytes", options->quota.stored_bytes, "Of clouds and outputs; 0: no limit")
      ->transform([](const std::string& text) {
        const auto bytes = number_in(SettingUnit::bytes, text);
        if (!bytes) throw CLI::ValidationError("'" + text + "' is no size like 4096, 512 MiB or 1.5 GB");
        return std::to_string(*bytes);
      })
      ->capture_default_str();
  add_verb("list", "Show the keys without their secrets", list_keys);
  add_verb("remove", "Take a key away; a running server notices", remove_key)
      ->add_option("ID", options->id)
      ->required();
}

}  // namespace surfaced
