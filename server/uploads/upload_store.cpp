// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/upload_store.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "platform/files.hpp"
#include "platform/random.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::chrono::hours kTombstone{24};
constexpr std::size_t kReadBytes = std::size_t{256} << 10;
constexpr std::size_t kIdDigits = 32;

/// What an id looks like; anything else never reaches the file system.
bool is_id(std::string_view text) {
  return text.size() == kIdDigits &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

Json record_of(const PartialUpload& upload) {
  return {{"id", upload.id},
          {"owner", upload.owner},
          {"length", upload.length},
          {"offset", upload.offset},
          {"metadata", upload.metadata},
          {"created_at", to_rfc3339(upload.created_at)},
          {"expires_at", to_rfc3339(upload.expires_at)},
          {"cloud", upload.cloud},
          {"gone", upload.gone}};
}

}  // namespace

Error no_such_upload(std::string_view id) {
  std::string text(id.substr(0, 64));
  return with_fault({ErrorCode::upload_not_found, "no upload has the id '" + text + "'"},
                    {"id", text, "the id of an upload that POST /v1/uploads has given"});
}

Result<std::unique_ptr<UploadStore>> UploadStore::open(const fs::path& directory, std::chrono::seconds lifetime) {
  if (Status made = make_directory(directory); !made.ok()) return made.error();
  return std::unique_ptr<UploadStore>(new UploadStore(directory, lifetime));
}

Result<PartialUpload> UploadStore::create(std::string_view owner, std::uint64_t length, std::string_view metadata) {
  const SystemTime time = now();
  PartialUpload upload{
      random_hex<16>(), std::string(owner), length, 0, std::string(metadata), time, time + lifetime_, "", false};
  const UniqueFd fd(::open(bytes_file(upload.id).c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!fd) return system_error("begin an upload", errno);
  if (Status saved = save(upload); !saved.ok()) {
    ::unlink(bytes_file(upload.id).c_str());
    return saved.error();
  }
  return upload;
}

Result<PartialUpload> UploadStore::load(std::string_view id) const {
  const Error unknown = no_such_upload(id);
  if (!is_id(id)) return unknown;
  std::ifstream file(record_file(id));
  if (!file) return unknown;
  const Json json = Json::parse(file, nullptr, false);
  try {
    return PartialUpload{json.at("id").get<std::string>(),
                         json.at("owner").get<std::string>(),
                         json.at("length").get<std::uint64_t>(),
                         json.at("offset").get<std::uint64_t>(),
                         json.at("metadata").get<std::string>(),
                         from_rfc3339(json.at("created_at").get<std::string>()),
                         from_rfc3339(json.at("expires_at").get<std::string>()),
                         json.at("cloud").get<std::string>(),
                         json.at("gone").get<bool>()};
  } catch (const Json::exception& damaged) {
    return Error{ErrorCode::internal_error, std::string("the record of an upload is damaged: ") + damaged.what()};
  }
}

Status UploadStore::save(const PartialUpload& upload) const {
  const std::string text = record_of(upload).dump(-1, ' ', false, Json::error_handler_t::replace);
  return write_file_durably(record_file(upload.id), text);
}

Result<PartialUpload> UploadStore::find(std::string_view id) {
  auto upload = load(id);
  if (!upload) return upload;
  if (!upload->gone && upload->expires_at > now()) return upload;
  return with_fault(
      {ErrorCode::upload_gone, "the upload '" + upload->id + "' " +
                                   (upload->gone ? "was ended" : "expired at " + to_rfc3339(upload->expires_at))},
      {"id", upload->id, "an upload that is going on"});
}

bool UploadStore::take(const std::string& id) {
  const std::scoped_lock lock(mutex_);
  return busy_.insert(id).second;
}

void UploadStore::release(const std::string& id) {
  const std::scoped_lock lock(mutex_);
  busy_.erase(id);
}

Result<UploadStore::Session> UploadStore::begin(std::string_view id) {
  if (!is_id(id)) return load(id).error();
  const std::string name(id);
  if (!take(name)) {
    return Error{ErrorCode::upload_busy, "another request is writing to the upload '" + name + "'"};
  }
  auto upload = find(id);
  if (!upload) {
    release(name);
    return std::move(upload).error();
  }
  UniqueFd fd(::open(bytes_file(id).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!fd && upload->cloud.empty()) {
    release(name);
    return system_error("open an upload", errno);
  }
  Session session(*this, std::move(*upload), std::move(fd));
  // What a request that broke off, or a server that died, has left behind the offset.
  const PartialUpload& known = session.upload();
  if (known.cloud.empty() && ::ftruncate(session.bytes_.get(), static_cast<off_t>(known.offset)) != 0) {
    return system_error("go on with an upload", errno);
  }
  return session;
}

UploadStore::Session::Session(UploadStore& store, PartialUpload upload, UniqueFd bytes)
    : store_(&store), upload_(std::move(upload)), bytes_(std::move(bytes)) {}

UploadStore::Session::Session(Session&& other) noexcept
    : store_(std::exchange(other.store_, nullptr)),
      upload_(std::move(other.upload_)),
      bytes_(std::move(other.bytes_)),
      written_(other.written_) {}

UploadStore::Session::~Session() {
  if (store_ != nullptr) store_->release(upload_.id);
}

Status UploadStore::Session::write(std::span<const std::byte> bytes) {
  const std::uint64_t end = upload_.offset + written_;
  if (bytes.size() > upload_.length - end) {
    return Error{ErrorCode::payload_too_large,
                 "the upload has " + std::to_string(upload_.length) + " bytes by its Upload-Length, and more are sent"};
  }
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count =
        ::pwrite(bytes_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(end + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error("store the upload", errno);
    done += static_cast<std::size_t>(count);
  }
  written_ += bytes.size();
  return Done{};
}

Result<PartialUpload> UploadStore::Session::keep() {
  if (::fsync(bytes_.get()) != 0) return system_error("store the upload", errno);
  PartialUpload next = upload_;
  next.offset += written_;
  next.expires_at = now() + store_->lifetime_;
  if (Status saved = store_->save(next); !saved.ok()) return saved.error();
  upload_ = next;
  written_ = 0;
  return upload_;
}

Status UploadStore::Session::read(const std::function<Status(std::span<const std::byte>)>& sink) const {
  std::vector<std::byte> buffer(kReadBytes);
  for (std::uint64_t at = 0; at < upload_.offset;) {
    const auto most = std::min<std::uint64_t>(buffer.size(), upload_.offset - at);
    const ssize_t count = ::pread(bytes_.get(), buffer.data(), most, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error("read an upload", errno);
    if (count == 0) return Error{ErrorCode::internal_error, "an upload has lost its bytes"};
    if (Status taken = sink(std::span(buffer).first(static_cast<std::size_t>(count))); !taken.ok()) return taken;
    at += static_cast<std::uint64_t>(count);
  }
  return Done{};
}

Status UploadStore::Session::became(const std::string& cloud) {
  PartialUpload next = upload_;
  next.cloud = cloud;
  if (Status saved = store_->save(next); !saved.ok()) return saved;
  upload_ = next;
  ::unlink(store_->bytes_file(upload_.id).c_str());
  return Done{};
}

Status UploadStore::Session::remove() {
  PartialUpload next = upload_;
  next.gone = true;
  next.expires_at = now();
  if (Status saved = store_->save(next); !saved.ok()) return saved;
  ::unlink(store_->bytes_file(upload_.id).c_str());
  return Done{};
}

std::size_t UploadStore::expire() {
  std::size_t dropped = 0;
  std::error_code error;
  std::vector<std::string> ids;
  for (const auto& entry : fs::directory_iterator(directory_, error)) {
    if (entry.path().extension() == ".json") ids.push_back(entry.path().stem().string());
  }
  const SystemTime time = now();
  for (const std::string& id : ids) {
    const auto upload = load(id);
    if (!upload || upload->expires_at > time || !take(id)) continue;
    if (::unlink(bytes_file(id).c_str()) == 0) ++dropped;
    if (upload->expires_at + kTombstone < time) ::unlink(record_file(id).c_str());
    release(id);
  }
  return dropped;
}

std::uint64_t UploadStore::promised_to(std::string_view owner) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory_, error)) {
    if (entry.path().extension() != ".json") continue;
    const auto upload = find(entry.path().stem().string());
    if (upload && upload->owner == owner && upload->cloud.empty()) bytes += upload->length;
  }
  return bytes;
}

}  // namespace surfaced
