// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/unpacking.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "base/text.hpp"
#include "io/scalars.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"
#include "io/zip.hpp"

namespace surfaced::io {
namespace {

constexpr std::uint64_t kMostUnpacked = std::uint64_t{32} << 20;
constexpr std::uint64_t kUnpackedPerByte = 40;
constexpr std::size_t kLeastGzip = 18;

/// Extensions that only clouds and meshes have, and those of any table.
constexpr auto kClouds = std::to_array<std::string_view>(
    {".ply", ".drc", ".las", ".pcd", ".glb", ".gltf", ".obj", ".stl", ".xyz", ".pts", ".xyzn", ".xyzrgb", ".asc"});
constexpr auto kTables = std::to_array<std::string_view>({".csv", ".txt", ".dat", ".tsv", ".neu"});

std::uint64_t most_unpacked(std::size_t packed) { return kMostUnpacked + kUnpackedPerByte * packed; }

std::string extension_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos ? std::string() : in_lower_case(name.substr(dot));
}

/// Programs put such files into archives of their own accord.
bool is_hidden(std::string_view name) {
  const std::size_t slash = name.rfind('/');
  const std::string_view last = slash == std::string_view::npos ? name : name.substr(slash + 1);
  return last.starts_with('.') || name.starts_with("__MACOSX/");
}

std::string names_of(const std::vector<const ZipMember*>& members) {
  std::string names;
  for (const ZipMember* member : members) {
    if (names.size() > 200) return names + ", ...";
    names += (names.empty() ? "" : ", ") + in_quotes(member->name);
  }
  return names;
}

std::vector<const ZipMember*> with_extensions(const std::vector<ZipMember>& members, const auto& extensions) {
  std::vector<const ZipMember*> found;
  for (const ZipMember& member : members) {
    const bool wanted = std::ranges::find(extensions, extension_of(member.name)) != extensions.end();
    if (wanted && !is_hidden(member.name)) found.push_back(&member);
  }
  return found;
}

/// Documents that are archives too.
std::optional<std::string> document_in(const std::vector<ZipMember>& members) {
  constexpr auto kDocuments = std::to_array<std::pair<std::string_view, std::string_view>>(
      {{"xl/workbook.xml", "an Excel workbook; save the sheet with the points as CSV"},
       {"word/document.xml", "a Word document, not points"},
       {"ppt/presentation.xml", "a presentation, not points"},
       {"content.xml", "an OpenDocument file; save its table as CSV"},
       {".npy", "NumPy arrays; write the points as text with numpy.savetxt(\"points.xyz\", array[:, :3])"},
       {".kml", "a KMZ document; export its points, projected to metres, as text with x y z"},
       {"/data.pkl", "a PyTorch file; write its points as text with numpy.savetxt(\"points.xyz\", points[:, :3])"},
       {"means_l.webp", "packed Gaussian splats (SOG); convert them to PLY"},
       {".rcs", "a ReCap project; export its points as PTS or E57, and convert that to PLY or LAS"},
       {".shp", "a shapefile of ESRI; export its points as text with x y z"},
       {".usdc", "a USD scene; export it as GLB, OBJ or PLY"}});
  for (const ZipMember& member : members) {
    for (const auto& [end, what] : kDocuments) {
      if (member.name.ends_with(end)) return std::string(what);
    }
  }
  return std::nullopt;
}

/// Inflates into `bytes` until the gzip ends, however many members it has.
class Inflater {
 public:
  Inflater(std::span<const std::byte> packed, std::string_view name) : packed_(packed), name_(name) {}
  ~Inflater() {
    if (begun_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  Result<Bytes> run() {
    begun_ = inflateInit2(&stream_, MAX_WBITS + 16) == Z_OK;
    if (!begun_) return refuse(ErrorCode::out_of_memory, "zlib cannot begin");
    const std::uint64_t most = most_unpacked(packed_.size());
    // The last four bytes declare the length; it is a first guess, and not believed beyond what text of points packs
    // to.
    const std::uint64_t declared = load_little<std::uint32_t>(packed_.data() + packed_.size() - 4);
    Bytes bytes(static_cast<std::size_t>(std::min({most, declared + 1, 16 * packed_.size() + 65536})));
    std::size_t length = 0;
    for (std::size_t taken = 0;;) {
      const int status = step(taken, bytes, length);
      if (status == Z_STREAM_END && !goes_on(taken)) break;
      if (status == Z_STREAM_END) {
        inflateReset(&stream_);
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        return refuse(ErrorCode::malformed_input, "the gzip is damaged after " + std::to_string(taken) + " bytes");
      } else if (length < bytes.size()) {
        if (status == Z_OK && taken < packed_.size()) continue;
        return refuse(ErrorCode::truncated_input, "the gzip ends after " + std::to_string(length) + " unpacked bytes");
      } else if (bytes.size() >= most) {
        return refuse(ErrorCode::unsupported_feature, std::to_string(packed_.size()) +
                                                          " bytes of gzip unpack to more than " + std::to_string(most) +
                                                          ", the limit for so few; send it unpacked");
      }
      if (length == bytes.size())
        bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(most, 2 * length + 1024)));
    }
    bytes.resize(length);
    return bytes;
  }

 private:
  Error refuse(ErrorCode code, const std::string& what) const { return {code, std::string(name_) + ": " + what}; }

  int step(std::size_t& taken, Bytes& bytes, std::size_t& length) {
    constexpr std::size_t kPiece = std::size_t{1} << 30;  // zlib counts with 32 bits
    const std::size_t in = std::min(kPiece, packed_.size() - taken);
    const std::size_t out = std::min(kPiece, bytes.size() - length);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed_.data() + taken));
    stream_.avail_in = static_cast<uInt>(in);
    stream_.next_out = reinterpret_cast<Bytef*>(bytes.data() + length);
    stream_.avail_out = static_cast<uInt>(out);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    taken += in - stream_.avail_in;
    length += out - stream_.avail_out;
    return status;
  }

  /// Another member follows: bgzip and pigz write many.
  bool goes_on(std::size_t taken) const { return looks_like_gzip(packed_.subspan(taken)); }

  std::span<const std::byte> packed_;
  std::string_view name_;
  z_stream stream_{};
  bool begun_ = false;
};

/// The path of a URI relative to a folder; none if it leads out of it.
std::optional<std::string> path_of_uri(std::string_view uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const bool escaped = uri[i] == '%' && i + 2 < uri.size() &&
                         std::from_chars(uri.data() + i + 1, uri.data() + i + 3, value, 16).ptr == uri.data() + i + 3;
    path += escaped ? static_cast<char>(value) : uri[i];
    if (escaped) i += 2;
  }
  const std::filesystem::path parts(path);
  const bool leaves = parts.is_absolute() || path.empty() || path.find('\0') != std::string::npos ||
                      path.find('\\') != std::string::npos || path.find("://") != std::string::npos ||
                      std::ranges::any_of(parts, [](const auto& part) { return part == ".."; });
  if (leaves) return std::nullopt;
  return parts.lexically_normal().string();
}

Error leads_out(const std::string& uri) {
  return {ErrorCode::unsupported_feature, in_quotes(uri) + " leads out of the folder of the glTF"};
}

std::uint16_t unit_at(std::span<const std::byte> bytes, std::size_t i, bool big) {
  const auto unit = load_little<std::uint16_t>(bytes.data() + i);
  return big ? static_cast<std::uint16_t>(unit << 8U | unit >> 8U) : unit;
}

void append_utf8(Bytes& text, std::uint32_t c) {
  const auto push = [&](std::uint32_t byte) { text.push_back(static_cast<std::byte>(byte)); };
  if (c < 0x80) {
    push(c);
  } else if (c < 0x800) {
    push(0xC0U | c >> 6U);
    push(0x80U | (c & 0x3FU));
  } else if (c < 0xD800 || c >= 0xE000) {
    push(0xE0U | c >> 12U);
    push(0x80U | (c >> 6U & 0x3FU));
    push(0x80U | (c & 0x3FU));
  } else {
    push('?');  // half of a character beyond 16 bits, of which no number and no known name has one
  }
}

}  // namespace

bool looks_like_gzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0x1F} && bytes[1] == std::byte{0x8B} && bytes[2] == std::byte{8};
}

Result<Bytes> gunzipped(std::span<const std::byte> bytes, std::string_view name) {
  if (bytes.size() >= kLeastGzip) return Inflater(bytes, name).run();
  return Error{ErrorCode::truncated_input, std::string(name) + ": a gzip has " + std::to_string(kLeastGzip) +
                                               " bytes at least, not " + std::to_string(bytes.size())};
}

Result<Unwrapped> cloud_in_zip(std::span<const std::byte> bytes, std::string_view name) {
  const Result<std::vector<ZipMember>> members = zip_directory(bytes, name);
  if (!members) return members.error();
  std::vector<const ZipMember*> found = with_extensions(*members, kClouds);
  if (found.empty()) found = with_extensions(*members, kTables);
  if (found.empty() && members->size() == 1) found.push_back(&members->front());
  if (found.empty() || found.size() == members->size()) {
    if (const auto document = document_in(*members)) {
      return Error{ErrorCode::unknown_format, std::string(name) + " is " + *document};
    }
  }
  if (found.size() != 1) {
    std::vector<const ZipMember*> all;
    for (const ZipMember& member : *members) all.push_back(&member);
    const std::string what =
        found.empty() ? "the ZIP archive holds no cloud that is read here; its files: " + names_of(all)
                      : "the ZIP archive holds " + std::to_string(found.size()) + " clouds, " + names_of(found);
    return Error{ErrorCode::unsupported_feature, std::string(name) + ": " + what + "; send one cloud"};
  }
  Result<Bytes> unpacked = unpack_member(bytes, *found.front(), most_unpacked(bytes.size()), name);
  if (!unpacked) return std::move(unpacked).error();
  return Unwrapped{found.front()->name, std::move(*unpacked)};
}

Beside beside_in_zip(std::span<const std::byte> bytes, std::string_view name, const std::string& member) {
  const std::size_t slash = member.rfind('/');
  std::string folder = slash == std::string::npos ? std::string() : member.substr(0, slash + 1);
  auto room = std::make_shared<std::uint64_t>(most_unpacked(bytes.size()));
  const auto files = std::make_shared<std::map<std::string, ZipMember>>();
  if (const Result<std::vector<ZipMember>> members = zip_directory(bytes, name)) {
    for (const ZipMember& each : *members) files->emplace(each.name, each);
  }
  return [bytes, name, folder = std::move(folder), files, room](const std::string& uri) -> Result<Bytes> {
    const std::optional<std::string> path = path_of_uri(uri);
    if (!path) return leads_out(uri);
    const auto found = files->find(folder + *path);
    if (found == files->end()) {
      return Error{ErrorCode::unsupported_feature, std::string(name) + ": the archive has no file " +
                                                       in_quotes(folder + *path) +
                                                       ", which the glTF names; put it into the archive"};
    }
    Result<Bytes> unpacked = unpack_member(bytes, found->second, *room, name);
    if (unpacked) *room -= std::min<std::uint64_t>(*room, unpacked->size());
    return unpacked;
  };
}

Beside beside_in_folder(const std::filesystem::path& folder) {
  return [folder](const std::string& uri) -> Result<Bytes> {
    const std::optional<std::string> path = path_of_uri(uri);
    if (!path) return leads_out(uri);
    const std::filesystem::path file = folder / *path;
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
      return Error{ErrorCode::input_unreadable, file.string() + " is no file"};
    }
    Result<ByteSource> source = ByteSource::open(file);
    if (!source) return std::move(source).error();
    const std::span<const std::byte> bytes = source->rest();
    if (source->failure()) return *source->failure();
    return Bytes(bytes.begin(), bytes.end());
  };
}

bool looks_like_utf16(std::span<const std::byte> bytes) {
  if (bytes.size() < 4) return false;
  const auto mark = load_little<std::uint16_t>(bytes.data());
  const bool wide = bytes[2] == std::byte{0} && bytes[3] == std::byte{0};  // UTF-32
  if (mark == 0xFEFF || mark == 0xFFFE) return !wide;
  if (bytes.size() < 16) return false;
  std::array<std::size_t, 2> zeros{};
  for (std::size_t i = 0; i < 16; ++i) zeros.at(i % 2) += bytes[i] == std::byte{0} ? 1U : 0U;
  return (zeros[0] == 8 && zeros[1] == 0) || (zeros[0] == 0 && zeros[1] == 8);
}

Bytes utf8_of_utf16(std::span<const std::byte> bytes) {
  const bool big = bytes[0] == std::byte{0xFE} || bytes[0] == std::byte{0};
  const bool marked = unit_at(bytes, 0, big) == 0xFEFF;
  Bytes text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = marked ? 2 : 0; i + 1 < bytes.size(); i += 2) append_utf8(text, unit_at(bytes, i, big));
  return text;
}

}  // namespace surfaced::io
