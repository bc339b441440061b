// SPDX-License-Identifier: GPL-3.0-or-later
// glTF made by hand and taken apart.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace surfaced::testing {

using Json = nlohmann::ordered_json;

struct Glb {
  Json json;
  std::string binary;
};

inline std::uint32_t word_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

inline Glb take_apart(const std::vector<std::byte>& bytes) {
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t json_size = word_at(bytes, 12);
  return {Json::parse(text.substr(20, json_size)), text.substr(28 + json_size)};
}

inline std::vector<std::byte> put_together(const Glb& glb) {
  std::string json = glb.json.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string text = "glTF";
  const auto word = [&](std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    text.append(reinterpret_cast<const char*>(&narrow), 4);
  };
  word(2);
  word(28 + json.size() + glb.binary.size());
  word(json.size());
  text += "JSON" + json;
  word(glb.binary.size());
  text += std::string("BIN\0", 4) + glb.binary;
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

}  // namespace surfaced::testing
