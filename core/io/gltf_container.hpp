// SPDX-License-Identifier: GPL-3.0-or-later
// The outer form of glTF: JSON, buffers and what accessors point at in them.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/formats.hpp"

namespace surfaced::io {

/// Thrown inside the glTF reader, whose steps are many and small; read_gltf_mesh turns it into a Result.
struct Refusal {
  Error error;
};

/// Elements of an accessor, checked to lie within their buffer.
struct Elements {
  const std::byte* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  int component_type = 0;
  std::size_t components = 0;
  bool normalized = false;

  const std::byte* at(std::size_t i) const { return data + i * stride; }
};

/// A glTF document whose JSON has been parsed and whose buffers are at hand. Every number and index is
/// checked where it is used: nothing in the file is believed.
class GltfDocument {
 public:
  /// GLB or JSON text. @throws Refusal
  /// @param beside  gives the files that buffers lie in; without it such buffers are refused.
  GltfDocument(std::span<const std::byte> bytes, std::string_view name, const Beside& beside);

  /// Bytes of the file and of the buffers beside it.
  std::size_t size() const { return size_; }

  const nlohmann::json& json() const { return json_; }
  std::string_view name() const { return name_; }

  /// Member `key` of an object, or null where it is absent. @throws Refusal if `object` is no object.
  const nlohmann::json& member(const nlohmann::json& object, std::string_view key) const;

  /// Entry `index` of a top-level array. @throws Refusal malformed_input if there is none.
  const nlohmann::json& entry(std::string_view array, std::uint64_t index) const;

  /// A whole number from 0 on. @throws Refusal malformed_input if it is something else.
  std::uint64_t whole(const nlohmann::json& value, std::string_view what) const;
  std::uint64_t whole(const nlohmann::json& object, std::string_view key, std::uint64_t otherwise) const;

  /// `count` numbers. @throws Refusal malformed_input
  std::vector<double> numbers(const nlohmann::json& value, std::size_t count, std::string_view what) const;

  /// @throws Refusal: sparse accessors and those without a bufferView are unsupported_feature.
  Elements accessor(std::uint64_t index) const;
  std::span<const std::byte> buffer_view(std::uint64_t index) const;

  [[noreturn]] void malformed(const std::string& what) const;
  [[noreturn]] void unsupported(const std::string& what) const;
  [[noreturn]] void refuse(ErrorCode code, const std::string& what) const;

 private:
  std::span<const std::byte> split_glb(std::span<const std::byte> bytes);
  void parse_json(std::span<const std::byte> text);
  void load_buffers(const Beside& beside);
  void unpack_views(std::size_t file_size);
  void unpack_view(std::size_t index, const nlohmann::json& packed, std::uint64_t& room);
  std::span<const std::byte> bytes_within(const nlohmann::json& view, const std::string& which) const;
  std::span<const std::byte> load_uri(const std::string& uri, std::size_t buffer, const Beside& beside);
  void check_is_gltf(std::string_view text) const;
  void check_is_one_object(std::string_view text) const;

  std::string_view name_;
  std::size_t size_;
  nlohmann::json json_;
  std::span<const std::byte> binary_;
  bool has_binary_ = false;
  std::vector<Bytes> decoded_;
  std::vector<std::span<const std::byte>> buffers_;
  /// What EXT_meshopt_compression packed, by the number of its view; views that are not packed are empty here.
  std::vector<Bytes> unpacked_;
};

}  // namespace surfaced::io
