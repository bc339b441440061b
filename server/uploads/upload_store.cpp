// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/upload_store.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "artifacts/backup_lease.hpp"
#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/errors.hpp"
#include "jobs/sqlite/holding_rows.hpp"
#include "observability/log.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"
#include "uploads/upload_rows.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using sqlite::Transaction;

constexpr std::chrono::milliseconds kPatience{2'000};
constexpr std::chrono::hours kTombstone{24};
constexpr std::size_t kReadBytes = std::size_t{256} << 10;
constexpr std::size_t kIdDigits = 32;

/// What an id looks like; anything else never reaches the file system.
bool is_id(std::string_view text) {
  return text.size() == kIdDigits &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

/// A record as it was kept in a file; none if it cannot be read.
std::optional<PartialUpload> read_record(const fs::path& path) {
  std::ifstream file(path);
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
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

Error gone(const PartialUpload& upload, const std::string& why) {
  return with_fault({ErrorCode::upload_gone, "the upload '" + upload.id + "' " + why},
                    {"id", upload.id, "an upload that is going on"});
}

}  // namespace

/// The connection to the records, for one thread at a time.
struct UploadStore::Records {
  explicit Records(const fs::path& file) : database(file, kPatience) {}

  template <class Work>
  auto locked(Transaction::Kind kind, const Work& work) -> decltype(work(std::declval<sqlite::Database&>())) {
    return sqlite::guarded([&]() -> decltype(work(database)) {
      const std::scoped_lock lock(mutex);
      Transaction transaction(database, kind);
      auto result = work(database);
      if (result) transaction.commit();
      return result;
    });
  }

  std::mutex mutex;
  sqlite::Database database;
};

Error no_such_upload(std::string_view id) {
  std::string text(id.substr(0, 64));
  return with_fault({ErrorCode::upload_not_found, "no upload has the id '" + text + "'"},
                    {"id", text, "the id of an upload that POST /v1/uploads has given"});
}

UploadStore::UploadStore(fs::path data, const UploadLimits& limits, std::unique_ptr<Records> records)
    : data_(std::move(data)), directory_(data_ / "partial"), limits_(limits), records_(std::move(records)) {}

UploadStore::~UploadStore() = default;

Result<std::unique_ptr<UploadStore>> UploadStore::open(const fs::path& data, const UploadLimits& limits) {
  auto records = sqlite::guarded(
      [&]() -> Result<std::unique_ptr<Records>> { return std::make_unique<Records>(data / "jobs.sqlite"); });
  if (!records) return std::move(records).error();
  std::unique_ptr<UploadStore> store(new UploadStore(data, limits, std::move(*records)));
  if (Status made = make_directory(store->directory_); !made.ok()) return made.error();
  if (Status imported = store->import_files(); !imported.ok()) return imported.error();
  return store;
}

Status UploadStore::import_files() {
  const auto files = entries_of(directory_);
  if (!files) return files.error();
  for (const fs::path& file : *files) {
    if (file.extension() != ".json") continue;
    const auto upload = read_record(file);
    if (!upload || !is_id(upload->id)) {
      log(LogLevel::warning, "the record of an upload cannot be read; it and the bytes beside it are left alone",
          {{"file", file.string()}});
      continue;
    }
    const Status noted = records_->locked(Transaction::Kind::write, [&](sqlite::Database& database) -> Status {
      sqlite::insert_upload(database, *upload, upload->owner);
      return Done{};
    });
    if (!noted) return noted;
    ::unlink(file.c_str());
  }
  return Done{};
}

Status UploadStore::check_room(const Uploader& uploader) const {
  sqlite::Database& database = records_->database;
  if (!uploader.client.empty() && limits_.most_of_client > 0 &&
      sqlite::count_open_uploads(database, uploader.client, limits_.most_of_client) >= limits_.most_of_client) {
    return Error{ErrorCode::too_many_requests,
                 "the limit is " + std::to_string(limits_.most_of_client) + " open uploads of one client"};
  }
  if (sqlite::count_open_uploads(database, std::nullopt, limits_.most) < limits_.most) return Done{};
  return Error{ErrorCode::not_ready, std::to_string(limits_.most) + " uploads are open, which is the limit"};
}

Result<PartialUpload> UploadStore::create(const Uploader& uploader, std::uint64_t length, std::string_view metadata) {
  const SystemTime time = now();
  const PartialUpload upload{
      random_hex<16>(), uploader.owner, length, 0, std::string(metadata), time, time + limits_.lifetime, "", false};
  return records_->locked(Transaction::Kind::write, [&](sqlite::Database& database) -> Result<PartialUpload> {
    if (Status room = check_room(uploader); !room.ok()) return room.error();
    const Status may = sqlite::admit(database, uploader.owner, uploader.allowance, {0, length});
    if (!may) return may.error();
    sqlite::insert_upload(database, upload, uploader.client);
    return upload;
  });
}

Result<std::optional<PartialUpload>> UploadStore::load(std::string_view id) {
  return records_->locked(Transaction::Kind::read,
                          [&](sqlite::Database& database) -> Result<std::optional<PartialUpload>> {
                            return sqlite::select_upload(database, id);
                          });
}

Status UploadStore::save(const PartialUpload& upload) {
  return records_->locked(Transaction::Kind::write, [&](sqlite::Database& database) -> Status {
    sqlite::update_upload(database, upload);
    return Done{};
  });
}

Result<PartialUpload> UploadStore::find(std::string_view id) {
  if (!is_id(id)) return no_such_upload(id);
  auto upload = load(id);
  if (!upload) return std::move(upload).error();
  if (!upload->has_value()) return no_such_upload(id);
  if ((*upload)->gone) return gone(**upload, "was ended");
  if ((*upload)->expires_at <= now()) return gone(**upload, "expired at " + to_rfc3339((*upload)->expires_at));
  return std::move(**upload);
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
  if (!is_id(id)) return no_such_upload(id);
  const std::string name(id);
  if (!take(name)) {
    return Error{ErrorCode::upload_busy, "another request is writing to the upload '" + name + "'"};
  }
  auto upload = find(id);
  auto bytes = upload ? open_bytes(*upload) : Result<UniqueFd>(upload.error());
  if (!bytes) {
    release(name);
    return std::move(bytes).error();
  }
  return Session(*this, std::move(*upload), std::move(*bytes));
}

Result<UniqueFd> UploadStore::open_bytes(const PartialUpload& upload) {
  if (!upload.open()) return UniqueFd();
  UniqueFd fd(::open(bytes_file(upload.id).c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return system_error("open an upload", errno);
  const auto size = file_size(fd.get());
  if (!size) return size.error();
  if (*size < upload.offset) {
    PartialUpload lost = upload;
    lost.gone = true;
    if (Status noted = save(lost); !noted.ok()) return noted.error();
    return gone(upload,
                "has lost bytes: " + std::to_string(*size) + " of " + std::to_string(upload.offset) + " are there");
  }
  // What a request that broke off, or a server that died, has left behind the offset.
  if (::ftruncate(fd.get(), static_cast<off_t>(upload.offset)) != 0) return system_error("go on with an upload", errno);
  return fd;
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
  // Of a new file the name, too.
  if (upload_.offset == 0) {
    if (Status synced = sync_directory(store_->directory_); !synced.ok()) return synced.error();
  }
  PartialUpload next = upload_;
  next.offset += written_;
  next.expires_at = now() + store_->limits_.lifetime;
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
  store_->remove_bytes(upload_.id);
  return Done{};
}

Status UploadStore::Session::remove() {
  PartialUpload next = upload_;
  next.gone = true;
  next.expires_at = now();
  if (Status saved = store_->save(next); !saved.ok()) return saved;
  store_->remove_bytes(upload_.id);
  return Done{};
}

void UploadStore::remove_bytes(const std::string& id) const {
  // Else the sweep does it, when the backup is made.
  if (const auto lease = BackupLease::to_remove(data_)) ::unlink(bytes_file(id).c_str());
}

std::size_t UploadStore::end_expired() {
  const SystemTime time = now();
  const auto expired =
      records_->locked(Transaction::Kind::write, [&](sqlite::Database& database) -> Result<std::vector<std::string>> {
        sqlite::purge_uploads(database, time - kTombstone);
        return sqlite::select_expired_uploads(database, time);
      });
  std::size_t ended = 0;
  for (const std::string& id : expired ? *expired : std::vector<std::string>()) {
    if (!take(id)) continue;
    auto upload = load(id);
    // A session may have gone on with it meanwhile.
    if (upload && upload->has_value() && (*upload)->open() && (*upload)->expires_at <= time) {
      (*upload)->gone = true;
      if (save(**upload).ok()) ++ended;
    }
    release(id);
  }
  return ended;
}

void UploadStore::remove_strays() {
  const auto lease = BackupLease::to_remove(data_);
  if (!lease) return;
  const auto files = entries_of(directory_);
  // Asked for after the files were listed: a row is there before its file is.
  const auto open =
      records_->locked(Transaction::Kind::read, [](sqlite::Database& database) -> Result<std::vector<PartialUpload>> {
        return sqlite::select_open_uploads(database);
      });
  if (!files || !open) return;
  std::set<fs::path> known;
  for (const PartialUpload& upload : *open) known.insert(bytes_file(upload.id));
  std::error_code error;
  for (const fs::path& file : *files) {
    // A record that could not be taken over stays, and the bytes that it tells of.
    const bool told_of = file.extension() == ".json" || fs::exists(fs::path(file).replace_extension(".json"), error);
    if (!known.contains(file) && !told_of) fs::remove_all(file, error);
  }
}

std::size_t UploadStore::sweep() {
  const std::size_t ended = end_expired();
  remove_strays();
  return ended;
}

Result<std::vector<std::string>> UploadStore::whole() {
  return records_->locked(Transaction::Kind::read, [](sqlite::Database& database) -> Result<std::vector<std::string>> {
    std::vector<std::string> ids;
    for (const PartialUpload& upload : sqlite::select_open_uploads(database)) {
      if (upload.whole()) ids.push_back(upload.id);
    }
    return ids;
  });
}

}  // namespace surfaced
