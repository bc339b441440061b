// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/upload_rows.hpp"

namespace surfaced::sqlite {
namespace {

constexpr const char* kOne =
    "SELECT id, owner, length, offset, metadata, created_at, expires_at, cloud, gone FROM uploads WHERE id = ?";
constexpr const char* kOpen =
    "SELECT id, owner, length, offset, metadata, created_at, expires_at, cloud, gone FROM uploads "
    "WHERE cloud = '' AND gone = 0";

PartialUpload read_upload(const Query& query) {
  return {query.text(0),
          query.text(1),
          static_cast<std::uint64_t>(query.number(2)),
          static_cast<std::uint64_t>(query.number(3)),
          query.text(4),
          from_rfc3339(query.text(5)),
          from_rfc3339(query.text(6)),
          query.text(7),
          query.number(8) != 0};
}

}  // namespace

void insert_upload(Database& database, const PartialUpload& upload, std::string_view client) {
  const std::string created = to_rfc3339(upload.created_at);
  const std::string expires = to_rfc3339(upload.expires_at);
  Query(database,
        "INSERT INTO uploads (id, owner, client, length, offset, metadata, created_at, expires_at, cloud, gone) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO NOTHING")
      .bind(upload.id)
      .bind(upload.owner)
      .bind(client)
      .bind(static_cast<std::int64_t>(upload.length))
      .bind(static_cast<std::int64_t>(upload.offset))
      .bind(upload.metadata)
      .bind(created)
      .bind(expires)
      .bind(upload.cloud)
      .bind(std::int64_t{upload.gone})
      .run();
}

std::optional<PartialUpload> select_upload(Database& database, std::string_view id) {
  Query query(database, kOne);
  query.bind(id);
  return query.step() ? std::optional(read_upload(query)) : std::nullopt;
}

void update_upload(Database& database, const PartialUpload& upload) {
  const std::string expires = to_rfc3339(upload.expires_at);
  Query(database, "UPDATE uploads SET offset = ?, cloud = ?, gone = ?, expires_at = ? WHERE id = ?")
      .bind(static_cast<std::int64_t>(upload.offset))
      .bind(upload.cloud)
      .bind(std::int64_t{upload.gone})
      .bind(expires)
      .bind(upload.id)
      .run();
}

std::size_t count_open_uploads(Database& database, std::optional<std::string_view> client, std::size_t most) {
  Query query(database, client ? "SELECT count(*) FROM (SELECT 1 FROM uploads WHERE cloud = '' AND gone = 0 "
                                 "AND client = ?2 LIMIT ?1)"
                               : "SELECT count(*) FROM (SELECT 1 FROM uploads WHERE cloud = '' AND gone = 0 LIMIT ?1)");
  query.bind(static_cast<std::int64_t>(most));
  if (client) query.bind(*client);
  query.step();
  return static_cast<std::size_t>(query.number(0));
}

std::vector<PartialUpload> select_open_uploads(Database& database) {
  std::vector<PartialUpload> found;
  Query query(database, kOpen);
  while (query.step()) found.push_back(read_upload(query));
  return found;
}

std::vector<std::string> select_expired_uploads(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  std::vector<std::string> ids;
  Query query(database, "SELECT id FROM uploads WHERE expires_at <= ? AND cloud = '' AND gone = 0");
  query.bind(limit);
  while (query.step()) ids.push_back(query.text(0));
  return ids;
}

void purge_uploads(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  Query(database, "DELETE FROM uploads WHERE expires_at <= ? AND (cloud <> '' OR gone <> 0)").bind(limit).run();
}

}  // namespace surfaced::sqlite
