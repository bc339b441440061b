// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/configuration.hpp"

#include <gmock/gmock.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "base/nearest.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// As a table of Markdown can hold it.
std::string in_words(std::string allowed) {
  for (std::size_t at = 0; (at = allowed.find('|', at)) != allowed.npos; at += 4) allowed.replace(at, 1, " or ");
  return allowed;
}

std::vector<std::string> details(const Configuration& configuration) {
  std::vector<std::string> texts;
  for (const Error& problem : configuration.problems) texts.push_back(problem.detail);
  return texts;
}

class ConfigurationTest : public ::testing::Test {
 protected:
  ConfigurationTest() {
    sources_.flags["data"] = "/tmp";
    sources_.environment = [this](const std::string& name) {
      const auto found = environment_.find(name);
      return found == environment_.end() ? std::nullopt : std::optional(found->second);
    };
  }
  std::string write(const std::string& name, const std::string& content) {
    const auto path = directory_.path() / name;
    std::ofstream(path) << content;
    return path.string();
  }
  Configuration read() const { return read_configuration(sources_); }
  std::string source_of(const Configuration& configuration, std::string_view name) const {
    for (const auto& entry : configuration.entries) {
      if (entry.setting->name == name) return entry.source;
    }
    return "absent";
  }

  testing::TemporaryDirectory directory_;
  std::map<std::string, std::string> environment_;
  Sources sources_;
};

TEST_F(ConfigurationTest, a_flag_wins_over_the_environment_and_that_over_the_file) {
  sources_.file = write("c.json", R"({"queue-limit": 1, "workers": 2, /* why */ "ttl": "3 s"})");
  environment_ = {{"SURFACED_QUEUE_LIMIT", "10"}, {"SURFACED_WORKERS", "20"}};
  sources_.flags["queue-limit"] = "100";
  const Configuration configuration = read();
  EXPECT_THAT(details(configuration), IsEmpty());
  EXPECT_EQ(configuration.settings.queue_limit, 100U);
  EXPECT_EQ(configuration.settings.workers, 20U);
  EXPECT_EQ(configuration.settings.ttl, 3U);
  EXPECT_EQ(source_of(configuration, "queue-limit"), "--queue-limit");
  EXPECT_EQ(source_of(configuration, "workers"), "SURFACED_WORKERS");
  EXPECT_EQ(source_of(configuration, "ttl"), "file");
  EXPECT_EQ(source_of(configuration, "lease"), "default");
  EXPECT_EQ(configuration.entries.size(), setting_table().size());
}

TEST_F(ConfigurationTest, a_value_can_lie_in_a_file_of_its_own) {
  environment_ = {{"SURFACED_LISTEN_FILE", write("listen", "127.0.0.1:99\n")}};
  const Configuration configuration = read();
  EXPECT_EQ(configuration.settings.listen, "127.0.0.1:99");
  EXPECT_EQ(source_of(configuration, "listen"), "SURFACED_LISTEN_FILE");
  environment_["SURFACED_LISTEN"] = "127.0.0.1:98";
  EXPECT_THAT(details(read()), ElementsAre("SURFACED_LISTEN and SURFACED_LISTEN_FILE are both set"));
  environment_ = {{"SURFACED_LISTEN_FILE", "/nonexistent"}};
  EXPECT_THAT(details(read()), ElementsAre(HasSubstr("'/nonexistent', which cannot be read")));
}

TEST_F(ConfigurationTest, everything_that_is_wrong_is_told_at_once_with_the_value_and_what_is_allowed) {
  sources_.file = write("c.json", R"({"queue-limit": -1, "nonsense": 1, "log-format": "xml"})");
  environment_ = {{"SURFACED_LEASE", "2 h"}};
  sources_.flags["job-output"] = "5 PiB";
  sources_.flags["bodies"] = "64";
  EXPECT_THAT(details(read()),
              ::testing::UnorderedElementsAre(HasSubstr("queue-limit is -1 in the file"),
                                              HasSubstr("sets 'nonsense', which is no setting"),
                                              "log-format is 'xml'; allowed is text|json (from file)",
                                              "lease is '2 h'; allowed is 3 s to 1 h (from SURFACED_LEASE)",
                                              HasSubstr("job-output is '5 PiB'; allowed is 1 MiB to"),
                                              "bodies is 64; allowed is less than http-threads, which is 64"));
}

TEST_F(ConfigurationTest, sizes_take_units_and_nothing_that_overflows) {
  Settings settings;
  const auto* const memory = &*std::ranges::find(setting_table(), "job-memory", &Setting::name);
  for (const auto& [text, bytes] : std::map<std::string, std::uint64_t>{{"4096", 4096},
                                                                        {"64KiB", 65536},
                                                                        {"4 GiB", std::uint64_t{4} << 30},
                                                                        {"1m", 1 << 20},
                                                                        {"2GB", std::uint64_t{2} << 30},
                                                                        {"1.5G", std::uint64_t{3} << 29},
                                                                        {"2 TB", std::uint64_t{2} << 40}}) {
    EXPECT_TRUE(assign(*memory, text, settings).ok()) << text;
    EXPECT_EQ(settings.job_memory, bytes) << text;
  }
  for (const char* text :
       {"", "x", "-1", "1.", ".5G", "1.2.3G", "1 G 2 M", "99999999999 TiB", "18446744073709551616", "1 GiB extra"}) {
    EXPECT_FALSE(assign(*memory, text, settings).ok()) << text;
  }
}

TEST_F(ConfigurationTest, durations_take_units_and_sums_but_no_part_of_a_second) {
  Settings settings;
  const auto* const ttl = &*std::ranges::find(setting_table(), "ttl", &Setting::name);
  for (const auto& [text, seconds] : std::map<std::string, std::uint64_t>{{"90", 90},
                                                                          {"90s", 90},
                                                                          {"15 min", 900},
                                                                          {"15m", 900},
                                                                          {"1.5 h", 5400},
                                                                          {"1d", 86400},
                                                                          {"1 D", 86400},
                                                                          {"2w", 14 * 86400},
                                                                          {"1h 30min", 5400}}) {
    EXPECT_TRUE(assign(*ttl, text, settings).ok()) << text;
    EXPECT_EQ(settings.ttl, seconds) << text;
  }
  for (const char* text : {"", "d", "1x", "0.5s", "-1d", "1d2", "1h 30", "366 d", "99999999999999999999 d", "1 d d"}) {
    EXPECT_FALSE(assign(*ttl, text, settings).ok()) << text;
  }
  EXPECT_EQ(with_unit(SettingUnit::seconds, 86400), "1 d");
  EXPECT_EQ(with_unit(SettingUnit::seconds, 5400), "90 min");
  EXPECT_EQ(with_unit(SettingUnit::seconds, 0), "0 s");
}

TEST_F(ConfigurationTest, units_are_taken_from_every_source) {
  sources_.file = write("c.json", R"({"ttl": "1d", "body-limit": "2GB"})");
  environment_ = {{"SURFACED_JOB_TIME_LIMIT", "90min"}};
  sources_.flags["gone-time"] = "2w";
  EXPECT_THAT(details(read()), IsEmpty());
  EXPECT_EQ(read().settings.ttl, 86400U);
  EXPECT_EQ(read().settings.body_limit, std::uint64_t{2} << 30);
  EXPECT_EQ(read().settings.job_time_limit, 5400U);
  EXPECT_EQ(read().settings.gone_time, 14U * 86400);
}

TEST_F(ConfigurationTest, what_is_wrong_names_the_setting_the_value_and_what_was_meant) {
  sources_.file = write("c.json", R"({"quue-limit": 5})");
  sources_.flags["log-format"] = "jsn";
  sources_.flags["ttl"] = "1 fortnight";
  const Configuration configuration = read();
  ASSERT_EQ(configuration.problems.size(), 3U);
  EXPECT_EQ(did_you_mean(configuration.problems[0]), "Did you mean 'queue-limit'?");
  EXPECT_EQ(did_you_mean(configuration.problems[1]), "Did you mean 'json'?");
  EXPECT_EQ(configuration.problems[2].fault->field, "ttl");
  EXPECT_EQ(configuration.problems[2].fault->value, "1 fortnight");
  EXPECT_EQ(configuration.problems[2].fault->allowed, "1 s to 365 d");
}

TEST_F(ConfigurationTest, what_is_shown_can_be_read_again) {
  const Settings defaults;
  for (const Setting& setting : setting_table()) {
    Settings read_again;
    const std::string text = shown(setting, defaults);
    if (text.empty()) continue;
    EXPECT_TRUE(assign(setting, text, read_again).ok()) << setting.name << " " << text;
    EXPECT_EQ(shown(setting, read_again), text);
  }
}

TEST_F(ConfigurationTest, the_data_folder_has_no_default) {
  sources_.flags.clear();
  EXPECT_THAT(details(read()),
              ElementsAre("data is not set: name a folder for jobs and clouds with --data or SURFACED_DATA"));
}

TEST_F(ConfigurationTest, the_machine_is_asked_whether_it_can_do_what_is_wanted) {
  sources_.flags["data"] = write("file", "x") + "/data";
  sources_.flags["connections"] = "100000";
  sources_.flags["job-memory"] = "1000 TiB";
  Configuration configuration = read();
  EXPECT_THAT(details(configuration), IsEmpty());
  check_machine(configuration);
  EXPECT_THAT(details(configuration), ::testing::Contains(HasSubstr("is no folder that this user can write")));
  EXPECT_THAT(configuration.warnings, ::testing::Contains(HasSubstr("may use more than the machine's")));
}

TEST_F(ConfigurationTest, event_streams_leave_connections_for_other_requests) {
  sources_.flags["connections"] = "400";
  EXPECT_EQ(read().settings.streams, 300U);
  EXPECT_THAT(details(read()), IsEmpty());
  sources_.flags["streams"] = "400";
  EXPECT_THAT(details(read()), ElementsAre("streams is 400; allowed is less than connections, which is 400"));
  sources_.flags["streams"] = "399";
  EXPECT_THAT(details(read()), IsEmpty());
}

TEST_F(ConfigurationTest, waits_leave_connections_beside_those_of_the_streams) {
  EXPECT_EQ(read().settings.waits, 400U);
  sources_.flags["connections"] = "400";
  EXPECT_EQ(read().settings.waits, 80U);
  sources_.flags["streams"] = "399";
  EXPECT_EQ(read().settings.waits, 0U);
  EXPECT_THAT(details(read()), IsEmpty());
  sources_.flags["streams"] = "300";
  sources_.flags["waits"] = "100";
  EXPECT_THAT(details(read()),
              ElementsAre("waits is 100; allowed is less than the connections without the streams, which are 100"));
  sources_.flags["waits"] = "99";
  EXPECT_THAT(details(read()), IsEmpty());
}

TEST_F(ConfigurationTest, few_open_files_lower_the_default_of_streams_with_that_of_connections) {
  const auto end = [&] {
    const rlimit few{1024, 1024};
    ::setrlimit(RLIMIT_NOFILE, &few);
    Configuration configuration = read();
    check_machine(configuration);
    const Settings& settings = configuration.settings;
    const bool lower = configuration.problems.empty() && settings.connections < 1024 &&
                       settings.streams == settings.connections / 4 * 3;
    sources_.flags["streams"] = "1200";
    Configuration asked = read();
    check_machine(asked);
    ::_exit(lower && !asked.problems.empty() ? 0 : 1);
  };
  // In a child: a hard limit cannot be raised again.
  EXPECT_EXIT(end(), ::testing::ExitedWithCode(0), "");
}

TEST_F(ConfigurationTest, the_documentation_lists_every_setting_with_its_variable_default_and_bounds) {
  std::ifstream file(SURFACED_SOURCE "/docs/operations.md");
  std::ostringstream text;
  text << file.rdbuf();
  const Settings defaults;
  for (const Setting& setting : setting_table()) {
    std::string standard = shown(setting, defaults);
    if (standard.empty()) standard = "none";
    const std::string row = "| `" + std::string(setting.name) + "` | " + standard + " | " + in_words(allowed(setting)) +
                            " | " + std::string(setting.text) + " |";
    EXPECT_TRUE(text.str().find(row) != std::string::npos) << "missing or different in docs/operations.md: " << row;
  }
}

}  // namespace
}  // namespace surfaced
