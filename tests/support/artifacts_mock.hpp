// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gmock/gmock.h>

#include "artifacts/artifact_store.hpp"

namespace surfaced::testing {

class ArtifactsMock : public ArtifactStore {
 public:
  using Reader = Result<std::unique_ptr<OutputReader>>;
  MOCK_METHOD(Result<std::unique_ptr<Upload>>, begin_upload, (), (override));
  MOCK_METHOD(Result<std::filesystem::path>, input_file, (std::string_view), (override));
  MOCK_METHOD(bool, has_input, (std::string_view, std::uint64_t), (override));
  MOCK_METHOD(Result<std::filesystem::path>, begin_attempt, (const Claim&), (override));
  MOCK_METHOD(Result<std::vector<Output>>, publish, (const Claim&, std::span<const std::string>), (override));
  MOCK_METHOD(void, discard, (const Claim&), (override));
  MOCK_METHOD(Result<std::filesystem::path>, output_file, (const Claim&, std::string_view), (override));
  MOCK_METHOD(Reader, open_output, (const Claim&, std::string_view), (override));
  MOCK_METHOD(Reader, open_log, (const Claim&), (override));
  MOCK_METHOD(void, remove, (const Artifacts&), (override));
  MOCK_METHOD(Result<std::size_t>, sweep, (const Artifacts&), (override));
  MOCK_METHOD(Result<Artifacts>, listing, (), (override));
  MOCK_METHOD(Status, belong_to, (std::string_view), (override));
  MOCK_METHOD(Status, check_space, (std::uint64_t), (override));
  MOCK_METHOD(std::uint64_t, free_bytes, (), (override));
};

}  // namespace surfaced::testing
