// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/zip.hpp"

#include <zlib.h>

#include <limits>

#include "io/scalars.hpp"
#include "io/text.hpp"

namespace surfaced::io {
namespace {

constexpr std::uint32_t kLocal = 0x04034B50;
constexpr std::uint32_t kCentral = 0x02014B50;
constexpr std::uint32_t kEnd = 0x06054B50;
constexpr std::size_t kLocalSize = 30;
constexpr std::size_t kCentralSize = 46;
constexpr std::size_t kEndSize = 22;
constexpr std::uint16_t kVersion = 20;
constexpr std::uint16_t kDeflate = 8;
/// 1 January 1980, the least date there is.
constexpr std::uint16_t kDate = 33;
constexpr std::uint64_t kLimit = std::numeric_limits<std::uint32_t>::max();
/// Numbers in XML deflate to about a fifth; what is denser is no mesh.
constexpr std::uint64_t kMostRatio = 64;
constexpr std::uint64_t kSmall = std::uint64_t{1} << 20;

/// Raw deflate; empty if zlib fails.
Bytes deflated(const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  Bytes packed(deflateBound(&stream, static_cast<uLong>(text.size())));
  stream.next_in =
      reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib's interface; it does not write there
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int end = deflate(&stream, Z_FINISH);
  packed.resize(end == Z_STREAM_END ? stream.total_out : 0);
  deflateEnd(&stream);
  return packed;
}

struct Written {
  std::uint32_t crc = 0;
  std::uint32_t packed = 0;
  std::uint32_t size = 0;
  std::uint32_t offset = 0;
};

/// The fields that the local header and the directory share.
void append_common(Bytes& bytes, const ZipEntry& entry, const Written& written) {
  for (const std::uint16_t word : {kVersion, std::uint16_t{0}, kDeflate, std::uint16_t{0}, kDate})
    append_little(bytes, word);
  for (const std::uint32_t word : {written.crc, written.packed, written.size}) append_little(bytes, word);
  append_little(bytes, static_cast<std::uint16_t>(entry.name.size()));
  append_little(bytes, std::uint16_t{0});
}

void append_text(Bytes& bytes, std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  bytes.insert(bytes.end(), begin, begin + text.size());
}

Error damaged(std::string_view name, const std::string& what) {
  return {ErrorCode::malformed_input, std::string(name) + ": the ZIP archive is damaged: " + what};
}

/// The directory's end stands last, before a comment of up to 64 KiB.
Result<std::size_t> find_end(std::span<const std::byte> bytes, std::string_view name) {
  if (bytes.size() < kEndSize) return damaged(name, std::to_string(bytes.size()) + " bytes");
  std::size_t end = bytes.size() - kEndSize;
  const std::size_t last = end < 65536 ? 0 : end - 65536;
  while (end > last && load_little<std::uint32_t>(bytes.data() + end) != kEnd) --end;
  if (load_little<std::uint32_t>(bytes.data() + end) != kEnd) return damaged(name, "it has no directory");
  return end;
}

/// The packed bytes of a member, from behind its local header.
Result<std::span<const std::byte>> packed_bytes(std::span<const std::byte> bytes, const ZipMember& member,
                                                std::string_view name) {
  if (member.offset > bytes.size() || bytes.size() - member.offset < kLocalSize) {
    return damaged(name, "an entry lies beyond its end");
  }
  const std::byte* const local = bytes.data() + member.offset;
  const std::uint64_t begin =
      member.offset + kLocalSize + load_little<std::uint16_t>(local + 26) + load_little<std::uint16_t>(local + 28);
  if (begin > bytes.size() || member.packed > bytes.size() - begin)
    return damaged(name, "an entry lies beyond its end");
  return bytes.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(member.packed));
}

Result<Bytes> inflated(std::span<const std::byte> packed, std::uint64_t size, std::string_view name) {
  Bytes unpacked(static_cast<std::size_t>(size));
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged(name, "zlib cannot begin");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
  stream.avail_out = static_cast<uInt>(unpacked.size());
  const int end = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (end != Z_STREAM_END || stream.avail_out != 0) return damaged(name, "an entry does not unpack to its size");
  return unpacked;
}

}  // namespace

Result<Bytes> write_zip(const std::vector<ZipEntry>& entries) {
  Bytes bytes;
  std::vector<Written> written;
  for (const ZipEntry& entry : entries) {
    if (entry.text.size() > kLimit / 2) {
      return Error{ErrorCode::output_not_writable, entry.name + " takes " + std::to_string(entry.text.size()) +
                                                       " bytes; 3MF is written up to 2 GiB; write .ply or .drc"};
    }
    const Bytes packed = deflated(entry.text);
    if (packed.empty()) return Error{ErrorCode::internal_error, "zlib cannot deflate " + entry.name};
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(entry.text.data()), static_cast<uInt>(entry.text.size())));
    written.push_back({crc, static_cast<std::uint32_t>(packed.size()), static_cast<std::uint32_t>(entry.text.size()),
                       static_cast<std::uint32_t>(bytes.size())});
    append_little(bytes, kLocal);
    append_common(bytes, entry, written.back());
    append_text(bytes, entry.name);
    bytes.insert(bytes.end(), packed.begin(), packed.end());
  }
  const auto directory = static_cast<std::uint32_t>(bytes.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    append_little(bytes, kCentral);
    append_little(bytes, kVersion);
    append_common(bytes, entries[i], written[i]);
    bytes.resize(bytes.size() + 10);  // comment, disk, attributes: none
    append_little(bytes, written[i].offset);
    append_text(bytes, entries[i].name);
  }
  const auto length = static_cast<std::uint32_t>(bytes.size() - directory);
  const auto count = static_cast<std::uint16_t>(entries.size());
  append_little(bytes, kEnd);
  append_little(bytes, std::uint32_t{0});
  append_little(bytes, count);
  append_little(bytes, count);
  append_little(bytes, length);
  append_little(bytes, directory);
  append_little(bytes, std::uint16_t{0});
  return bytes;
}

bool looks_like_zip(std::span<const std::byte> bytes) {
  return bytes.size() >= 4 &&
         (load_little<std::uint32_t>(bytes.data()) == kLocal || load_little<std::uint32_t>(bytes.data()) == kEnd);
}

Result<std::vector<ZipMember>> zip_directory(std::span<const std::byte> bytes, std::string_view name) {
  const Result<std::size_t> end = find_end(bytes, name);
  if (!end) return end.error();
  const auto count = load_little<std::uint16_t>(bytes.data() + *end + 10);
  std::uint64_t at = load_little<std::uint32_t>(bytes.data() + *end + 16);
  std::vector<ZipMember> members;
  for (std::uint16_t i = 0; i < count; ++i) {
    if (at + kCentralSize > bytes.size()) return damaged(name, "its directory ends early");
    const std::byte* const entry = bytes.data() + at;
    if (load_little<std::uint32_t>(entry) != kCentral)
      return damaged(name, "entry " + std::to_string(i) + " of its directory");
    const std::uint64_t letters = load_little<std::uint16_t>(entry + 28);
    at += kCentralSize + letters;
    if (at > bytes.size()) return damaged(name, "its directory ends early");
    at += std::uint64_t{load_little<std::uint16_t>(entry + 30)} + load_little<std::uint16_t>(entry + 32);
    ZipMember member{
        .name = std::string(reinterpret_cast<const char*>(entry) + kCentralSize, static_cast<std::size_t>(letters)),
        .packed = load_little<std::uint32_t>(entry + 20),
        .size = load_little<std::uint32_t>(entry + 24),
        .offset = load_little<std::uint32_t>(entry + 42),
        .method = load_little<std::uint16_t>(entry + 10),
        .encrypted = (load_little<std::uint16_t>(entry + 8) & 1U) != 0};
    if (member.packed == kLimit || member.size == kLimit || member.offset == kLimit) {
      return Error{ErrorCode::unsupported_feature,
                   std::string(name) + ": " + in_quotes(member.name) +
                       " is a ZIP entry of 4 GiB or more; unpack it, or pack it as gzip"};
    }
    if (!member.name.ends_with('/')) members.push_back(std::move(member));
  }
  return members;
}

Result<Bytes> unpack_member(std::span<const std::byte> bytes, const ZipMember& member, std::uint64_t most,
                            std::string_view name) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::unsupported_feature, std::string(name) + ": " + in_quotes(member.name) + what};
  };
  if (member.encrypted) return refuse(" is encrypted; unpack it first");
  const Result<std::span<const std::byte>> packed = packed_bytes(bytes, member, name);
  if (!packed) return packed.error();
  if (member.size > most) {
    return refuse(": " + std::to_string(member.packed) + " bytes would unpack to " + std::to_string(member.size) +
                  "; the limit for so few is " + std::to_string(most) + "; send it unpacked");
  }
  if (member.method == 0 && member.packed == member.size) return Bytes(packed->begin(), packed->end());
  if (member.method != kDeflate) {
    return refuse(" is packed by method " + std::to_string(member.method) + "; pack it by deflate");
  }
  return inflated(*packed, member.size, name);
}

Result<std::string> read_zip_entry(std::span<const std::byte> bytes, std::string_view name_end, std::string_view name) {
  const Result<std::vector<ZipMember>> members = zip_directory(bytes, name);
  if (!members) return members.error();
  for (const ZipMember& member : *members) {
    if (!member.name.ends_with(name_end)) continue;
    const Result<Bytes> unpacked = unpack_member(bytes, member, kSmall + kMostRatio * member.packed, name);
    if (!unpacked) return unpacked.error();
    return std::string(reinterpret_cast<const char*>(unpacked->data()), unpacked->size());
  }
  return Error{ErrorCode::unsupported_feature,
               std::string(name) + ": the ZIP archive has no entry " + in_quotes(name_end)};
}

}  // namespace surfaced::io
