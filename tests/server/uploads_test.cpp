// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/upload_store.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "api/upload_headers.hpp"
#include "platform/files.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

class UploadsTest : public ::testing::Test {
 protected:
  void SetUp() override { open(std::chrono::hours(1)); }
  void open(std::chrono::seconds lifetime) {
    store_ = UploadStore::open(directory_.path() / "partial", lifetime).value();
  }
  std::string begin(std::uint64_t length = 10) { return store_->create("me", length, "name YQ==").value().id; }
  void append(const std::string& id, std::string_view text) {
    auto session = store_->begin(id).value();
    ASSERT_TRUE(session.write(as_bytes(text)).ok());
    ASSERT_TRUE(session.keep().ok());
  }
  std::string content(const std::string& id) {
    std::string text;
    const auto session = store_->begin(id).value();
    EXPECT_TRUE(session
                    .read([&](std::span<const std::byte> bytes) {
                      text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                      return Status(Done{});
                    })
                    .ok());
    return text;
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<UploadStore> store_;
};

TEST_F(UploadsTest, what_was_kept_survives_a_restart_and_what_was_not_is_cut_off) {
  const std::string id = begin();
  append(id, "abcd");
  {
    auto session = store_->begin(id).value();
    ASSERT_TRUE(session.write(as_bytes("xyz")).ok());
  }
  open(std::chrono::hours(1));
  EXPECT_EQ(store_->find(id).value().offset, 4U);
  append(id, "efghij");
  EXPECT_TRUE(store_->find(id).value().whole());
  EXPECT_EQ(content(id), "abcdefghij");
}

TEST_F(UploadsTest, two_cannot_write_at_once) {
  const std::string id = begin();
  const auto first = store_->begin(id).value();
  EXPECT_EQ(store_->begin(id).error().code, ErrorCode::upload_busy);
}

TEST_F(UploadsTest, more_than_the_length_is_refused) {
  auto session = store_->begin(begin(3)).value();
  EXPECT_EQ(session.write(as_bytes("abcd")).error().code, ErrorCode::payload_too_large);
}

TEST_F(UploadsTest, ended_and_expired_uploads_are_gone_and_unknown_ones_were_never_there) {
  const std::string id = begin();
  ASSERT_TRUE(store_->begin(id).value().remove().ok());
  EXPECT_EQ(store_->find(id).error().code, ErrorCode::upload_gone);
  open(std::chrono::seconds(0));
  const std::string late = begin();
  EXPECT_EQ(store_->find(late).error().code, ErrorCode::upload_gone);
  EXPECT_EQ(store_->expire(), 1U);
  EXPECT_EQ(store_->begin(late).error().code, ErrorCode::upload_gone);
  for (const char* other : {"", "..", "../jobs.sqlite", "00000000000000000000000000000000"}) {
    EXPECT_EQ(store_->find(other).error().code, ErrorCode::upload_not_found) << other;
    EXPECT_EQ(store_->begin(other).error().code, ErrorCode::upload_not_found) << other;
  }
}

TEST_F(UploadsTest, unfinished_uploads_count_with_their_whole_length) {
  begin(10);
  begin(7);
  EXPECT_EQ(store_->promised_to("me"), 17U);
  EXPECT_EQ(store_->promised_to("you"), 0U);
}

TEST(UploadHeadersTest, checksums_have_an_algorithm_and_its_length) {
  http::Headers headers;
  headers.add("Upload-Checksum", "sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=");
  EXPECT_EQ(api::checksum_header(headers).value()->digest.size(), 20U);
  for (const char* wrong : {"sha1", "sha1 ", "sha1 Kq5s", "crc9 Kq5sNclPz7QV2+lfQIuc6R7oRu0=", "sha1 !!", " "}) {
    http::Headers other;
    other.add("Upload-Checksum", wrong);
    EXPECT_FALSE(api::checksum_header(other).ok()) << wrong;
  }
}

TEST(UploadHeadersTest, metadata_is_pairs_of_a_name_and_base64) {
  const auto ok = [](const std::string& text) {
    http::Headers headers;
    headers.add("Upload-Metadata", text);
    return api::metadata_header(headers).ok();
  };
  EXPECT_TRUE(ok("filename YS5wbHk=,is_confidential"));
  EXPECT_TRUE(ok(""));
  EXPECT_FALSE(ok("filename a.ply"));
  EXPECT_FALSE(ok(",x"));
  EXPECT_FALSE(ok(std::string(5000, 'a')));
}

}  // namespace
}  // namespace surfaced
