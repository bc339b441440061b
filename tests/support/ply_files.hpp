// SPDX-License-Identifier: GPL-3.0-or-later
// PLY files made by hand, value by value.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace surfaced::testing {

inline std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

inline std::string with_crlf(std::string_view text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

enum class PlyForm : std::uint8_t { ascii, little, big };

/// Writes a header from calls, then the values in their order, each in the type it is given. Knows
/// nothing of rows: what does not fit the header makes a file that breaks the rules.
class PlyBuilder {
 public:
  explicit PlyBuilder(PlyForm form) : form_(form) {
    constexpr std::array<const char*, 3> kNames{"ascii", "binary_little_endian", "binary_big_endian"};
    header_ = std::string("ply\nformat ") + kNames.at(static_cast<std::size_t>(form)) + " 1.0\n";
  }

  PlyBuilder& line(const std::string& text) {
    header_ += text + "\n";
    return *this;
  }
  PlyBuilder& element(const std::string& name, std::uint64_t count) {
    return line("element " + name + " " + std::to_string(count));
  }
  PlyBuilder& property(const std::string& type, const std::string& name) {
    return line("property " + type + " " + name);
  }
  PlyBuilder& list(const std::string& count_type, const std::string& type, const std::string& name) {
    return line("property list " + count_type + " " + type + " " + name);
  }

  PlyBuilder& value(std::string_view type, double number) {
    if (form_ == PlyForm::ascii) {
      std::array<char, 64> text{};
      std::snprintf(text.data(), text.size(), type == "float" || type == "float32" ? "%.9g " : "%.17g ", number);
      body_ += text.data();
      return *this;
    }
    if (type == "char" || type == "int8") return append(static_cast<std::int8_t>(number));
    if (type == "uchar" || type == "uint8") return append(static_cast<std::uint8_t>(number));
    if (type == "short" || type == "int16") return append(static_cast<std::int16_t>(number));
    if (type == "ushort" || type == "uint16") return append(static_cast<std::uint16_t>(number));
    if (type == "int" || type == "int32") return append(static_cast<std::int32_t>(number));
    if (type == "uint" || type == "uint32") return append(static_cast<std::uint32_t>(number));
    if (type == "float" || type == "float32") return append(static_cast<float>(number));
    return append(number);
  }
  PlyBuilder& list_value(std::string_view count_type, std::string_view type, const std::vector<double>& values) {
    value(count_type, static_cast<double>(values.size()));
    for (const double v : values) value(type, v);
    return *this;
  }
  PlyBuilder& end_row() {
    if (form_ == PlyForm::ascii) body_ += "\n";
    return *this;
  }

  std::string text() const { return header_ + "end_header\n" + body_; }
  std::vector<std::byte> bytes() const { return bytes_of(text()); }
  PlyForm form() const { return form_; }

 private:
  template <class T>
  PlyBuilder& append(T number) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(T));
    const bool reversed = (std::endian::native == std::endian::big) != (form_ == PlyForm::big);
    body_ += reversed ? std::string(bytes.rbegin(), bytes.rend()) : std::string(bytes.begin(), bytes.end());
    return *this;
  }

  PlyForm form_;
  std::string header_;
  std::string body_;
};

/// A glTF of two nodes that share a mesh: a strip under a matrix, mirrored, and the plain one.
inline constexpr std::string_view kTwoNodes =
    R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[1,2,3],"children":[1]},)"
    R"({"mesh":0,"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,10,0,0,1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},)"
    R"("mode":5}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4,"min":[0,0,0],)"
    R"("max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":48}],"buffers":[{"byteLength":48,"uri":)"
    R"("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAA"}]})";

}  // namespace surfaced::testing
