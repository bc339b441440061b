// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/keys.hpp"

#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/sha256.hpp"
#include "base/text.hpp"
#include "io/io.hpp"
#include "platform/clock.hpp"
#include "platform/digest.hpp"
#include "platform/files.hpp"
#include "platform/lists.hpp"
#include "platform/random.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kPrefix = "sfd_";
constexpr std::string_view kScopeNames = "read, submit, metrics, admin";

std::string hash_of(std::string_view secret) {
  Sha256 sha;
  sha.update(as_bytes(secret));
  return sha.finish();
}

Json key_json(const Key& key) {
  return {{"id", key.id},
          {"name", key.name},
          {"created_at", key.created_at},
          {"secret_sha256", key.secret_sha256},
          {"scopes", names_of(key.scopes)},
          {"requests_per_minute", key.quota.requests_per_minute},
          {"submissions_per_minute", key.quota.submissions_per_minute},
          {"active_jobs", key.quota.active_jobs},
          {"stored_bytes", key.quota.stored_bytes}};
}

Result<Key> key_in(const Json& json) {
  const auto scopes = scopes_named(joined(json.at("scopes").get<std::vector<std::string>>(), ","));
  if (!scopes) return scopes.error();
  return Key{
      json.at("id").get<std::string>(),
      json.at("name").get<std::string>(),
      json.value("created_at", ""),
      json.at("secret_sha256").get<std::string>(),
      *scopes,
      {json.value("requests_per_minute", std::uint64_t{0}), json.value("submissions_per_minute", std::uint64_t{0}),
       json.value("active_jobs", std::uint64_t{0}), json.value("stored_bytes", std::uint64_t{0})}};
}

}  // namespace

Result<Scopes> scopes_named(std::string_view list) {
  Scopes scopes;
  const std::string whole(list);
  while (!list.empty()) {
    const std::string_view name = take_entry(list);
    if (name == "read") {
      scopes.read = true;
    } else if (name == "submit") {
      scopes.submit = true;
    } else if (name == "admin") {
      scopes = {true, true, true, true};
    } else if (name == "metrics") {
      scopes.metrics = true;
    } else {
      return Error{ErrorCode::invalid_usage, "the scopes are '" + whole + "'; allowed are " + std::string(kScopeNames)};
    }
  }
  if (!scopes.read && !scopes.submit && !scopes.metrics) {
    return Error{ErrorCode::invalid_usage, "a key needs a scope; there are " + std::string(kScopeNames)};
  }
  return scopes;
}

std::vector<std::string> names_of(const Scopes& scopes) {
  if (scopes.admin) return {"admin"};
  std::vector<std::string> names;
  if (scopes.read) names.emplace_back("read");
  if (scopes.submit) names.emplace_back("submit");
  if (scopes.metrics) names.emplace_back("metrics");
  return names;
}

Result<KeyRing> KeyRing::load(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) return Error{ErrorCode::invalid_usage, "the file of keys '" + file.string() + "' cannot be read"};
  KeyRing ring;
  try {
    const Json json = Json::parse(stream);
    for (const Json& each : json.at("keys")) {
      auto key = key_in(each);
      if (!key) return std::move(key).error();
      const std::string id = key->id;
      if (!ring.keys_.emplace(id, std::move(*key)).second) {
        return Error{ErrorCode::invalid_usage, "the file of keys '" + file.string() + "' has the id " + id + " twice"};
      }
    }
  } catch (const Json::exception& wrong) {
    return Error{ErrorCode::invalid_usage, "the file of keys '" + file.string() + "': " + wrong.what()};
  }
  return ring;
}

Status KeyRing::save(const std::filesystem::path& file) const {
  Json keys = Json::array();
  for (const auto& [id, key] : keys_) keys.push_back(key_json(key));
  const mode_t before = ::umask(0077);
  const Status written = write_file(file, as_bytes(Json{{"keys", std::move(keys)}}.dump(2) + "\n"));
  ::umask(before);
  return written;
}

std::string KeyRing::add(std::string name, const Scopes& scopes, const Quota& quota) {
  const std::string secret = random_hex<32>();
  Key key{random_hex<8>(), std::move(name), to_rfc3339(now()), hash_of(secret), scopes, quota};
  std::string text = std::string(kPrefix) + key.id + "_" + secret;
  std::string id = key.id;
  keys_.emplace(std::move(id), std::move(key));
  return text;
}

bool KeyRing::remove(std::string_view id) {
  const auto found = keys_.find(id);
  if (found == keys_.end()) return false;
  keys_.erase(found);
  return true;
}

const Key* KeyRing::with_id(std::string_view id) const {
  const auto found = keys_.find(id);
  return found == keys_.end() ? nullptr : &found->second;
}

const Key* KeyRing::find(std::string_view text) const {
  if (!text.starts_with(kPrefix)) return nullptr;
  text.remove_prefix(kPrefix.size());
  const std::size_t mark = text.find('_');
  if (mark == text.npos) return nullptr;
  const Key* const key = with_id(text.substr(0, mark));
  // The id is no secret; what is compared for a wrong one costs the same.
  static const std::string kNobody(64, '0');
  const bool right =
      equal_in_constant_time(hash_of(text.substr(mark + 1)), key != nullptr ? key->secret_sha256 : kNobody);
  return right ? key : nullptr;
}

}  // namespace surfaced
