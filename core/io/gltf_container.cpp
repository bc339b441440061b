// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/gltf_container.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "io/meshopt.hpp"
#include "io/scalars.hpp"
#include "io/strangers.hpp"
#include "io/text.hpp"

namespace surfaced::io {
namespace {

using Json = nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546C67;
constexpr std::uint32_t kGlbJson = 0x4E4F534A;
constexpr std::uint32_t kGlbBinary = 0x004E4942;
constexpr std::size_t kGlbHeader = 12;
constexpr std::size_t kChunkHeader = 8;
/// What packed views may take: this, and so many bytes for every byte of the file.
constexpr std::uint64_t kUnpackedSmall = std::uint64_t{64} << 20;
constexpr std::uint64_t kUnpackedPerByte = 16;

const Json kAbsent;

struct Component {
  int type;
  std::size_t size;
};
constexpr auto kComponents =
    std::to_array<Component>({{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}});

constexpr auto kShapes =
    std::to_array<std::pair<std::string_view, std::size_t>>({{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}});

/// Value of every base64 digit; 64 for what is none.
constexpr std::array<std::uint8_t, 256> base64_values() {
  std::array<std::uint8_t, 256> values{};
  values.fill(64);
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    values.at(static_cast<unsigned char>(kDigits[i])) = static_cast<std::uint8_t>(i);
  }
  return values;
}

/// Decodes base64, with or without padding; false at the first character that is no digit.
bool decode_base64(std::string_view text, Bytes& bytes) {
  static constexpr std::array<std::uint8_t, 256> kValues = base64_values();
  while (text.ends_with('=')) text.remove_suffix(1);
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::uint8_t value = kValues.at(static_cast<unsigned char>(c));
    if (value > 63) return false;
    bits = bits << 6 | value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xFFU));
  }
  return true;
}

/// A buffer that stands for what packed views unpack to.
bool is_fallback(const Json& buffer) {
  const auto extensions = buffer.find("extensions");
  return extensions != buffer.end() && extensions->is_object() && extensions->contains(kMeshoptExtension);
}

}  // namespace

GltfDocument::GltfDocument(std::span<const std::byte> bytes, std::string_view name, const Beside& beside)
    : name_(name), size_(bytes.size()) {
  const bool binary = bytes.size() >= 4 && load_little<std::uint32_t>(bytes.data()) == kGlbMagic;
  parse_json(binary ? split_glb(bytes) : bytes);
  load_buffers(beside);
  unpack_views(size_);
}

void GltfDocument::refuse(ErrorCode code, const std::string& what) const {
  throw Refusal{{code, std::string(name_) + ": " + what}};
}
void GltfDocument::malformed(const std::string& what) const { refuse(ErrorCode::malformed_input, what); }
void GltfDocument::unsupported(const std::string& what) const { refuse(ErrorCode::unsupported_feature, what); }

std::span<const std::byte> GltfDocument::split_glb(std::span<const std::byte> bytes) {
  if (bytes.size() < kGlbHeader + kChunkHeader) {
    refuse(ErrorCode::truncated_input,
           "the GLB has " + std::to_string(bytes.size()) + " bytes; its headers alone take 20");
  }
  const auto version = load_little<std::uint32_t>(bytes.data() + 4);
  if (version != 2) unsupported("GLB version " + std::to_string(version) + "; 2 is read");
  const auto length = load_little<std::uint32_t>(bytes.data() + 8);
  if (length > bytes.size()) {
    refuse(ErrorCode::truncated_input,
           "the GLB declares " + std::to_string(length) + " bytes, " + std::to_string(bytes.size()) + " are there");
  }
  bytes = bytes.first(length);
  std::span<const std::byte> text;
  std::size_t at = kGlbHeader;
  for (std::size_t chunk = 0; at < bytes.size(); ++chunk) {
    if (bytes.size() - at < kChunkHeader) malformed("the GLB ends within the header of chunk " + std::to_string(chunk));
    const auto size = load_little<std::uint32_t>(bytes.data() + at);
    const auto type = load_little<std::uint32_t>(bytes.data() + at + 4);
    at += kChunkHeader;
    if (size > bytes.size() - at) {
      malformed("chunk " + std::to_string(chunk) + " of the GLB declares " + std::to_string(size) + " bytes, " +
                std::to_string(bytes.size() - at) + " are left");
    }
    if (chunk == 0) {
      if (type != kGlbJson) malformed("the first chunk of the GLB is not JSON");
      text = bytes.subspan(at, size);
    } else if (chunk == 1 && type == kGlbBinary) {
      binary_ = bytes.subspan(at, size);
      has_binary_ = true;
    }
    at += size;
  }
  return text;
}

void GltfDocument::parse_json(std::span<const std::byte> text) {
  const auto* begin = reinterpret_cast<const char*>(text.data());
  try {
    json_ = Json::parse(begin, begin + text.size());
  } catch (const Json::parse_error& error) {
    check_is_one_object({begin, text.size()});
    const std::string size = std::to_string(text.size());
    malformed(error.byte > text.size() ? "its JSON ends too early, after " + size + " bytes"
                                       : "its JSON breaks at byte " + std::to_string(error.byte) + " of " + size);
  } catch (const Json::out_of_range&) {
    malformed("its JSON holds a number beyond the range of double");
  }
  if (!json_.is_object()) malformed("its JSON is no object");
  check_is_gltf({begin, text.size()});
  const Json& asset = member(json_, "asset");
  const Json& version = member(asset, "version");
  if (!version.is_string()) malformed("'asset.version' is missing");
  if (!version.get_ref<const std::string&>().starts_with("2.")) {
    unsupported("glTF version " + in_quotes(version.get_ref<const std::string&>()) + "; 2.0 is read");
  }
}

/// Other JSON is named for what it is.
void GltfDocument::check_is_gltf(std::string_view text) const {
  if (member(json_, "asset").is_object()) return;
  throw Refusal{{ErrorCode::unknown_format, std::string(name_) + " is " + json_stranger(text.substr(0, 4096)) +
                                                " (a glTF has an object 'asset')"}};
}

/// A first line that is an object of its own begins a file of many.
void GltfDocument::check_is_one_object(std::string_view text) const {
  const std::string_view line = text.substr(0, text.find('\n'));
  if (line.size() == text.size() || !Json::parse(line, nullptr, false).is_object()) return;
  throw Refusal{{ErrorCode::unknown_format, std::string(name_) + " is " + json_stranger(line.substr(0, 4096)) +
                                                " (every line of it is an object of its own)"}};
}

void GltfDocument::load_buffers(const Beside& beside) {
  const Json& buffers = member(json_, "buffers");
  if (buffers.is_null()) return;
  if (!buffers.is_array()) malformed("'buffers' is no array");
  decoded_.resize(buffers.size());
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::uint64_t length = whole(member(buffers[i], "byteLength"), "byteLength of a buffer");
    const Json& uri = member(buffers[i], "uri");
    std::span<const std::byte> data;
    if (uri.is_string()) {
      data = load_uri(uri.get_ref<const std::string&>(), i, beside);
    } else if (i == 0 && has_binary_ && uri.is_null()) {
      data = binary_;
    } else if (uri.is_null() && is_fallback(buffers[i])) {
      buffers_.emplace_back();  // only packed views may refer to it
      continue;
    } else {
      unsupported("buffer " + std::to_string(i) + " has no data in the file");
    }
    if (length > data.size()) {
      refuse(ErrorCode::truncated_input, "buffer " + std::to_string(i) + " declares " + std::to_string(length) +
                                             " bytes, " + std::to_string(data.size()) + " are there");
    }
    buffers_.push_back(data.first(static_cast<std::size_t>(length)));
  }
}

std::span<const std::byte> GltfDocument::load_uri(const std::string& uri, std::size_t buffer, const Beside& beside) {
  constexpr std::string_view kMark = ";base64,";
  const std::string which = "buffer " + std::to_string(buffer);
  if (!uri.starts_with("data:")) {
    if (!beside) {
      unsupported(which + " lies in another file, " + in_quotes(uri) +
                  "; send both in one ZIP archive, embed it, or write a GLB");
    }
    Result<Bytes> bytes = beside(uri);
    if (!bytes) throw Refusal{std::move(bytes).error()};
    decoded_[buffer] = std::move(*bytes);
    size_ += decoded_[buffer].size();
    return decoded_[buffer];
  }
  const std::size_t mark = uri.find(kMark);
  if (mark == std::string::npos) unsupported(which + " is a data URI without base64");
  if (!decode_base64(std::string_view(uri).substr(mark + kMark.size()), decoded_[buffer])) {
    malformed(which + " is not base64");
  }
  return decoded_[buffer];
}

const Json& GltfDocument::member(const Json& object, std::string_view key) const {
  if (!object.is_object()) malformed("an object with the member " + in_quotes(key) + " was expected");
  const auto found = object.find(key);
  return found == object.end() ? kAbsent : *found;
}

const Json& GltfDocument::entry(std::string_view array, std::uint64_t index) const {
  const Json& entries = member(json_, array);
  const std::size_t there = entries.is_array() ? entries.size() : 0;
  if (index >= there) {
    malformed(std::string(array) + "[" + std::to_string(index) + "] does not exist; there are " +
              std::to_string(there));
  }
  return entries[static_cast<std::size_t>(index)];
}

std::uint64_t GltfDocument::whole(const Json& value, std::string_view what) const {
  if (!value.is_number_unsigned()) malformed(std::string(what) + " is no whole number from 0 on");
  return value.get<std::uint64_t>();
}

std::uint64_t GltfDocument::whole(const Json& object, std::string_view key, std::uint64_t otherwise) const {
  const Json& value = member(object, key);
  return value.is_null() ? otherwise : whole(value, key);
}

std::vector<double> GltfDocument::numbers(const Json& value, std::size_t count, std::string_view what) const {
  if (!value.is_array() || value.size() != count) {
    malformed(std::string(what) + " is no array of " + std::to_string(count) + " numbers");
  }
  std::vector<double> result;
  for (const Json& number : value) {
    if (!number.is_number()) malformed(std::string(what) + " is no array of " + std::to_string(count) + " numbers");
    result.push_back(number.get<double>());
  }
  return result;
}

void GltfDocument::unpack_views(std::size_t file_size) {
  const Json& views = member(json_, "bufferViews");
  if (!views.is_array()) return;
  unpacked_.resize(views.size());
  std::uint64_t room = kUnpackedSmall + kUnpackedPerByte * file_size;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Json& extensions = member(views[i], "extensions");
    if (!extensions.is_object()) continue;
    if (const Json& packed = member(extensions, kMeshoptExtension); packed.is_object()) unpack_view(i, packed, room);
  }
}

void GltfDocument::unpack_view(std::size_t index, const Json& packed, std::uint64_t& room) {
  const std::string which = "the packed bufferViews[" + std::to_string(index) + "]";
  const std::span<const std::byte> bytes = bytes_within(packed, which);
  constexpr auto kModes =
      std::to_array<std::pair<std::string_view, MeshoptMode>>({{"ATTRIBUTES", MeshoptMode::attributes},
                                                               {"TRIANGLES", MeshoptMode::triangles},
                                                               {"INDICES", MeshoptMode::indices}});
  constexpr auto kFilters =
      std::to_array<std::pair<std::string_view, MeshoptFilter>>({{"NONE", MeshoptFilter::none},
                                                                 {"OCTAHEDRAL", MeshoptFilter::octahedral},
                                                                 {"QUATERNION", MeshoptFilter::quaternion},
                                                                 {"EXPONENTIAL", MeshoptFilter::exponential}});
  const auto named = [&](const auto& table, std::string_view key, const std::string& otherwise) {
    const Json& value = member(packed, key);
    const std::string name = value.is_string() ? value.get<std::string>() : value.is_null() ? otherwise : "?";
    const auto* found = std::ranges::find(table, std::string_view(name), [](const auto& row) { return row.first; });
    if (found == table.end()) malformed(which + "." + std::string(key) + " is " + in_quotes(name));
    return found->second;
  };
  const std::uint64_t count = whole(member(packed, "count"), which + ".count");
  const std::uint64_t stride = whole(member(packed, "byteStride"), which + ".byteStride");
  if (stride > 256 || count > room / std::max<std::uint64_t>(stride, 1)) {
    unsupported(which + " holds " + std::to_string(count) + " elements of " + std::to_string(stride) + " bytes; " +
                std::to_string(room) + " bytes are left for a file of this size");
  }
  const MeshoptView view{.mode = named(kModes, "mode", "?"),
                         .filter = named(kFilters, "filter", "NONE"),
                         .count = static_cast<std::size_t>(count),
                         .stride = static_cast<std::size_t>(stride)};
  if (!is_sound(view)) malformed(which + " has a mode, filter, count and stride that do not go together");
  Bytes& target = unpacked_[index];
  target.resize(view.count * view.stride);
  if (!unpack(view, bytes, target)) malformed(which + " is damaged");
  room -= target.size();
}

std::span<const std::byte> GltfDocument::bytes_within(const Json& view, const std::string& which) const {
  const std::uint64_t buffer = whole(member(view, "buffer"), which + ".buffer");
  const std::uint64_t offset = whole(view, "byteOffset", 0);
  const std::uint64_t length = whole(member(view, "byteLength"), which + ".byteLength");
  if (buffer >= buffers_.size()) {
    malformed(which + " refers to buffer " + std::to_string(buffer) + " of " + std::to_string(buffers_.size()));
  }
  const std::span<const std::byte> data = buffers_[static_cast<std::size_t>(buffer)];
  if (offset > data.size() || length > data.size() - offset) {
    malformed(which + " takes bytes " + std::to_string(offset) + " to " + std::to_string(offset) + "+" +
              std::to_string(length) + " of a buffer of " + std::to_string(data.size()));
  }
  return data.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
}

std::span<const std::byte> GltfDocument::buffer_view(std::uint64_t index) const {
  const Json& view = entry("bufferViews", index);
  const Bytes& unpacked = unpacked_[static_cast<std::size_t>(index)];
  if (!unpacked.empty()) return unpacked;
  return bytes_within(view, "bufferViews[" + std::to_string(index) + "]");
}

Elements GltfDocument::accessor(std::uint64_t index) const {
  const Json& accessor = entry("accessors", index);
  const std::string which = "accessors[" + std::to_string(index) + "]";
  if (!member(accessor, "sparse").is_null()) unsupported(which + " is sparse");
  if (member(accessor, "bufferView").is_null()) unsupported(which + " has no bufferView");
  const std::uint64_t view_index = whole(accessor, "bufferView", 0);
  const std::span<const std::byte> view = buffer_view(view_index);
  Elements elements;
  const std::uint64_t type = whole(member(accessor, "componentType"), which + ".componentType");
  const auto* component =
      std::ranges::find_if(kComponents, [&](const Component& c) { return static_cast<std::uint64_t>(c.type) == type; });
  if (component == kComponents.end()) malformed(which + ".componentType is " + std::to_string(type));
  const Json& shape_name = member(accessor, "type");
  const auto* shape = std::ranges::find_if(kShapes, [&](const auto& s) {
    return shape_name.is_string() && shape_name.get_ref<const std::string&>() == s.first;
  });
  if (shape == kShapes.end()) unsupported(which + ".type is none of SCALAR, VEC2, VEC3, VEC4");
  elements.component_type = component->type;
  elements.components = shape->second;
  const Json& normalized = member(accessor, "normalized");
  elements.normalized = normalized.is_boolean() && normalized.get<bool>();
  const std::size_t size = component->size * shape->second;
  const std::uint64_t stride = whole(entry("bufferViews", view_index), "byteStride", size);
  const std::uint64_t offset = whole(accessor, "byteOffset", 0);
  const std::uint64_t count = whole(member(accessor, "count"), which + ".count");
  if (stride < size || stride > 252) malformed(which + " has a byteStride of " + std::to_string(stride));
  const std::uint64_t room =
      offset > view.size() || view.size() - offset < size ? 0 : (view.size() - offset - size) / stride + 1;
  if (count > room) {
    malformed(which + " declares " + std::to_string(count) + " elements; its bufferView has room for " +
              std::to_string(room));
  }
  elements.count = static_cast<std::size_t>(count);
  elements.stride = static_cast<std::size_t>(stride);
  elements.data = count == 0 ? view.data() : view.data() + offset;
  return elements;
}

}  // namespace surfaced::io
