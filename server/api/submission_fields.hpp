// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/submission.hpp"
#include "base/base.hpp"
#include "http/message.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {

/// The fields of a submission, decoded from where they stand and not judged yet: the one reader of submissions
/// (read_submission) asks for them by name, whatever form they came in.
class SubmissionFields {
 public:
  SubmissionFields() = default;
  SubmissionFields(const SubmissionFields&) = delete;
  SubmissionFields& operator=(const SubmissionFields&) = delete;
  virtual ~SubmissionFields() = default;

  /// Refuses names that there are not, or not here.
  virtual Status check_names() const = 0;
  /// Empty if the field is absent.
  virtual Result<std::string> text(std::string_view name) const = 0;
  struct Number {
    /// Not a number if the text is none.
    double value = 0;
    std::string text;
  };
  virtual Result<std::optional<Number>> number(std::string_view name) const = 0;
  /// Entries in their order; of labels not many more than are allowed.
  virtual Result<std::vector<std::string>> list(std::string_view name) const = 0;
  /// All parameters of the method, with defaults.
  virtual Result<nlohmann::ordered_json> parameters(const MethodInfo& method) const = 0;
};

/// In a query, or in the fields of a form, whose names are the same.
class QueryFields final : public SubmissionFields {
 public:
  QueryFields(const http::Query& query, Endpoint endpoint) : query_(query), endpoint_(endpoint) {}

  Status check_names() const override;
  Result<std::string> text(std::string_view name) const override;
  Result<std::optional<Number>> number(std::string_view name) const override;
  Result<std::vector<std::string>> list(std::string_view name) const override;
  Result<nlohmann::ordered_json> parameters(const MethodInfo& method) const override;

 private:
  /// Of a path that answers with the mesh: the format of that one.
  Result<std::vector<std::string>> output() const;

  const http::Query& query_;
  const Endpoint endpoint_;
};

/// In a body of JSON; OGC's execute requests become such a body (ogc_json.hpp).
class JsonFields final : public SubmissionFields {
 public:
  explicit JsonFields(const nlohmann::ordered_json& body) : body_(body) {}

  Status check_names() const override;
  Result<std::string> text(std::string_view name) const override;
  Result<std::optional<Number>> number(std::string_view name) const override;
  Result<std::vector<std::string>> list(std::string_view name) const override;
  Result<nlohmann::ordered_json> parameters(const MethodInfo& method) const override;

 private:
  /// None if the member is absent or null.
  const nlohmann::ordered_json* find(std::string_view name) const;

  const nlohmann::ordered_json& body_;
};

}  // namespace surfaced::api
