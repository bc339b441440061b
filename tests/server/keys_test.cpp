// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/keys.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "access/pace.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class KeysTest : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return directory_.path() / "keys.json"; }
  testing::TemporaryDirectory directory_;
};

TEST_F(KeysTest, a_key_is_known_by_its_text_and_by_nothing_else) {
  KeyRing ring;
  const std::string text = ring.add("ci", scopes_named("read,submit").value(), {10, 5, 2, 1000});
  ASSERT_TRUE(ring.save(file()).ok());
  const KeyRing loaded = KeyRing::load(file()).value();
  const Key* const key = loaded.find(text);
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(key->name, "ci");
  EXPECT_EQ(key->quota.submissions_per_minute, 5U);
  EXPECT_EQ(key->quota.active_jobs, 2U);
  EXPECT_THAT(names_of(key->scopes), ElementsAre("read", "submit"));
  std::string wrong = text;
  wrong.back() = wrong.back() == '0' ? '1' : '0';
  for (const std::string& other : {wrong, text + "0", text.substr(0, text.size() - 1), "sfd_" + key->id + "_", key->id,
                                   key->secret_sha256, std::string("sfd_"), std::string()}) {
    EXPECT_EQ(loaded.find(other), nullptr) << other;
  }
}

TEST_F(KeysTest, the_file_holds_no_secret_and_is_for_its_owner_alone) {
  KeyRing ring;
  const std::string text = ring.add("ci", scopes_named("admin").value(), {});
  ASSERT_TRUE(ring.save(file()).ok());
  std::ifstream stream(file());
  const std::string content((std::istreambuf_iterator<char>(stream)), {});
  EXPECT_THAT(content, Not(HasSubstr(text.substr(text.rfind('_') + 1))));
  struct stat status {};
  ASSERT_EQ(::stat(file().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600);
}

TEST_F(KeysTest, wrong_scopes_and_broken_files_are_refused_with_their_name) {
  EXPECT_THAT(scopes_named("read,write").error().detail, HasSubstr("read,write"));
  EXPECT_FALSE(scopes_named("").ok());
  EXPECT_THAT(names_of(scopes_named(" read ,\tsubmit").value()), ElementsAre("read", "submit"));
  EXPECT_THAT(names_of(scopes_named("metrics").value()), ElementsAre("metrics"));
  EXPECT_FALSE(scopes_named("read,submit").value().metrics) << "it is a scope of its own";
  EXPECT_THAT(KeyRing::load(file()).error().detail, HasSubstr("keys.json"));
  for (const char* broken : {"", "{", "{}", "{\"keys\": [{}]}", "{\"keys\": [{\"id\": 1}]}"}) {
    std::ofstream(file()) << broken;
    EXPECT_EQ(KeyRing::load(file()).error().code, ErrorCode::invalid_usage) << broken;
  }
}

TEST(PaceTest, a_minutes_worth_at_once_and_then_the_rate) {
  Pace pace;
  const auto start = Pace::Clock::now();
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(pace.take("a", 60, start)) << i;
  EXPECT_EQ(pace.take("a", 60, start), std::chrono::seconds(1));
  EXPECT_FALSE(pace.take("b", 60, start));
  EXPECT_FALSE(pace.take("a", 60, start + std::chrono::milliseconds(1001)));
  EXPECT_TRUE(pace.take("a", 60, start + std::chrono::milliseconds(1001)));
}

}  // namespace
}  // namespace surfaced
