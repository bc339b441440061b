// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/draco_guard.hpp"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_kd_tree_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scalars.hpp"

namespace surfaced::io {
namespace {

constexpr std::size_t kHeaderSize = 11;
constexpr std::size_t kFlagsAt = 9;
constexpr std::uint16_t kMetadataFlag = 0x8000;

/// Entropy coding can say "a million equal points" in a few bytes, so a file may well be smaller than
/// its points; but not by any factor. Decoding a file of up to a MiB may take this much memory, and for
/// every byte beyond that so much more. (A triangle takes 80 bytes; 1.5 bits are the least that the
/// edgebreaker was seen to need for one, on a regular grid.)
constexpr std::uint64_t kMemoryOfSmallFile = std::uint64_t{160} << 20;
constexpr std::uint64_t kSmallFile = std::uint64_t{1} << 20;
constexpr std::uint64_t kMemoryPerByte = 1024;

/// What Draco and this room hold of a point besides its attributes: ids of a sequencer, and the
/// position, normal and colour that the caller gets.
constexpr std::uint64_t kMemoryPerPoint = 4 + 24 + 12 + 4;
/// Of a triangle while the edgebreaker runs: corner table, stacks, faces, points of corners.
constexpr std::uint64_t kMemoryPerFace = 80;
/// The same for every attribute that has seams of its own.
constexpr std::uint64_t kSeamMemoryPerFace = 24;

constexpr std::uint16_t version(std::uint8_t major, std::uint8_t minor) {
  return static_cast<std::uint16_t>(major << 8 | minor);
}

/// What one decoding may spend, and why it was refused if it was.
struct Budget {
  std::string_view name;
  std::uint64_t file_size;
  std::uint64_t max_points;
  std::optional<Error> refusal;

  std::uint64_t memory() const {
    return kMemoryOfSmallFile + kMemoryPerByte * (std::max(file_size, kSmallFile) - kSmallFile);
  }

  bool refuse(ErrorCode code, const std::string& what) {
    refusal = Error{code, std::string(name) + ": " + what};
    return false;
  }

  /// `cost` of what the file declares, in bytes.
  bool allows(std::uint64_t count, const char* what, std::uint64_t cost) {
    if (cost <= memory()) return true;
    return refuse(ErrorCode::malformed_input, "the Draco file of " + std::to_string(file_size) + " bytes declares " +
                                                  std::to_string(count) + " " + what + ", which take about " +
                                                  std::to_string(cost) + " bytes; the limit for its size is " +
                                                  std::to_string(memory()));
  }
};

/// Reads ahead in a copy of a buffer: what Draco itself will read next.
class Ahead {
 public:
  explicit Ahead(const draco::DecoderBuffer& buffer) : buffer_(buffer) {}

  std::uint64_t varint() {
    std::uint32_t value = 0;
    complete_ = complete_ && draco::DecodeVarint(&value, &buffer_);
    return value;
  }
  template <class T>
  T fixed() {
    T value{};
    complete_ = complete_ && buffer_.Decode(&value);
    return value;
  }
  void skip(std::uint64_t count) {
    complete_ = complete_ && count <= static_cast<std::uint64_t>(buffer_.remaining_size());
    if (complete_) buffer_.Advance(static_cast<std::int64_t>(count));
  }
  /// False once the buffer ended before what was asked for.
  bool complete() const { return complete_; }
  std::uint64_t remaining() const { return static_cast<std::uint64_t>(buffer_.remaining_size()); }
  std::uint64_t position() const { return static_cast<std::uint64_t>(buffer_.decoded_size()); }

 private:
  draco::DecoderBuffer buffer_;
  bool complete_ = true;
};

/// Memory that the attributes take once decoded: their values, their integer form, and the ids of the
/// points for each of the decoders.
std::uint64_t attribute_memory(const draco::PointCloud& cloud, std::uint64_t decoders) {
  std::uint64_t per_point = kMemoryPerPoint + 4 * decoders;
  for (int i = 0; i < cloud.num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *cloud.attribute(i);
    per_point += static_cast<std::uint64_t>(attribute.byte_stride()) + std::uint64_t{4} * attribute.num_components();
  }
  return per_point * cloud.num_points();
}

/// Called when all attributes are declared and none is decoded.
bool check_points(const draco::PointCloud& cloud, int decoders, Budget& budget) {
  if (cloud.num_points() == 0) return budget.refuse(ErrorCode::empty_input, "the Draco file declares 0 points");
  if (cloud.num_points() > budget.max_points) {
    return budget.refuse(ErrorCode::too_many_points, std::to_string(cloud.num_points()) + " points; the limit is " +
                                                         std::to_string(budget.max_points));
  }
  return budget.allows(cloud.num_points(), "points", attribute_memory(cloud, static_cast<std::uint64_t>(decoders)));
}

class SequentialCloud : public draco::PointCloudSequentialDecoder {
 public:
  explicit SequentialCloud(Budget& budget) : budget_(budget) {}

 protected:
  bool DecodeAllAttributes() override {
    return check_points(*point_cloud(), num_attributes_decoders(), budget_) &&
           draco::PointCloudSequentialDecoder::DecodeAllAttributes();
  }

 private:
  Budget& budget_;
};

/// The kd-tree repeats the number of points in front of its bits and believes it.
class KdTreeCloud : public draco::PointCloudKdTreeDecoder {
 public:
  explicit KdTreeCloud(Budget& budget) : budget_(budget) {}

 protected:
  bool DecodeAllAttributes() override {
    if (num_attributes_decoders() != 1) {
      return budget_.refuse(ErrorCode::malformed_input, "a kd-tree with " + std::to_string(num_attributes_decoders()) +
                                                            " attribute decoders; encoders write 1");
    }
    return check_points(*point_cloud(), 1, budget_) && check_dimension() && check_repeated_counts() &&
           draco::PointCloudKdTreeDecoder::DecodeAllAttributes();
  }

 private:
  /// The stacks of the tree hold 32 levels of every component, twice.
  bool check_dimension() {
    std::uint64_t dimension = 0;
    for (int i = 0; i < point_cloud()->num_attributes(); ++i) {
      dimension += point_cloud()->attribute(i)->num_components();
    }
    const std::uint64_t row = 4 * dimension + 40;
    return budget_.allows(dimension, "components of a kd-tree", 64 * dimension * row);
  }

  bool check_repeated_counts() {
    Ahead ahead(*buffer());
    if (bitstream_version() >= version(2, 3)) {
      ahead.skip(1 + 4);  // compression level, bit length
      return agrees(ahead);
    }
    const auto method = ahead.fixed<std::uint8_t>();
    ahead.skip(1);
    if (!agrees(ahead)) return false;
    if (method == 0) {  // quantised floats, as early versions wrote them
      const auto format = ahead.fixed<std::uint32_t>();
      if (format == 3) {
        if (ahead.fixed<std::uint8_t>() != 1) return unknown_tree("method");
      } else if (format != 2) {
        return unknown_tree("version");
      }
      ahead.skip(4 + 4);  // quantisation bits, range
      if (!agrees(ahead)) return false;
      ahead.skip(4);  // compression level
    }
    ahead.skip(4);  // bit length
    return agrees(ahead);
  }

  bool unknown_tree(const char* what) {
    return budget_.refuse(ErrorCode::malformed_input, std::string("the kd-tree has an unknown ") + what);
  }

  bool agrees(Ahead& ahead) {
    const auto repeated = ahead.fixed<std::uint32_t>();
    if (!ahead.complete()) return budget_.refuse(ErrorCode::truncated_input, "the file ends before its kd-tree");
    if (repeated == point_cloud()->num_points()) return true;
    return budget_.refuse(ErrorCode::malformed_input, "the kd-tree declares " + std::to_string(repeated) +
                                                          " points, the header " +
                                                          std::to_string(point_cloud()->num_points()));
  }

  Budget& budget_;
};

/// Draco bounds the faces of this encoding by the bytes left, the points by the faces.
class SequentialMesh : public draco::MeshSequentialDecoder {
 public:
  explicit SequentialMesh(Budget& budget) : budget_(budget) {}

 protected:
  bool DecodeAllAttributes() override {
    return check_points(*point_cloud(), num_attributes_decoders(), budget_) &&
           draco::MeshSequentialDecoder::DecodeAllAttributes();
  }

 private:
  Budget& budget_;
};

/// The edgebreaker allocates its corner table from the declared counts before it reads a symbol.
class EdgebreakerMesh : public draco::MeshEdgebreakerDecoder {
 public:
  explicit EdgebreakerMesh(Budget& budget) : budget_(budget) {}

 protected:
  bool DecodeConnectivity() override {
    Ahead ahead(*buffer());
    const bool varints = bitstream_version() >= version(2, 0);
    const auto count = [&] { return varints ? ahead.varint() : ahead.fixed<std::uint32_t>(); };
    if (bitstream_version() < version(2, 2)) count();  // vertices made by splits
    const std::uint64_t vertices = count();
    const std::uint64_t faces = count();
    const std::uint64_t seamed = ahead.fixed<std::uint8_t>();
    count();  // symbols: Draco refuses fewer than 3/4 of the faces
    const std::uint64_t splits = count();
    if (!ahead.complete()) return budget_.refuse(ErrorCode::truncated_input, "the file ends before its triangles");
    return budget_.allows(faces, "triangles", faces * (kMemoryPerFace + kSeamMemoryPerFace * seamed)) &&
           budget_.allows(vertices + splits, "vertices", (vertices + splits) * 16) &&
           draco::MeshEdgebreakerDecoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    return check_points(*point_cloud(), num_attributes_decoders(), budget_) &&
           draco::MeshEdgebreakerDecoder::DecodeAllAttributes();
  }

 private:
  Budget& budget_;
};

struct Header {
  std::uint8_t major;
  std::uint8_t minor;
  std::uint8_t type;
  std::uint8_t method;
  std::uint16_t flags;
};

Result<Header> read_header(std::span<const std::byte> bytes, std::string_view name) {
  if (bytes.size() < kHeaderSize) {
    return Error{ErrorCode::truncated_input, std::string(name) + ": a Draco file of " + std::to_string(bytes.size()) +
                                                 " bytes; its header alone takes " + std::to_string(kHeaderSize)};
  }
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint8_t>(bytes[i]); };
  const Header header{byte(5), byte(6), byte(7), byte(8), load_little<std::uint16_t>(bytes.data() + kFlagsAt)};
  const auto known = [&](std::uint8_t major, std::uint8_t minor) {
    return header.major >= 1 && version(header.major, header.minor) <= version(major, minor);
  };
  const bool readable =
      header.type == draco::POINT_CLOUD
          ? known(draco::kDracoPointCloudBitstreamVersionMajor, draco::kDracoPointCloudBitstreamVersionMinor)
          : known(draco::kDracoMeshBitstreamVersionMajor, draco::kDracoMeshBitstreamVersionMinor);
  const std::string version_text = std::to_string(header.major) + "." + std::to_string(header.minor);
  if (header.type > draco::TRIANGULAR_MESH || header.method > 1) {
    return Error{ErrorCode::unsupported_feature, std::string(name) + ": Draco geometry type " +
                                                     std::to_string(header.type) + " with encoding " +
                                                     std::to_string(header.method) + "; 0 and 1 are read"};
  }
  if (!readable) {
    return Error{ErrorCode::unsupported_feature, std::string(name) + ": Draco bitstream version " + version_text +
                                                     "; 1.0 to 2.3 are read (meshes to 2.2)"};
  }
  return header;
}

/// Walks over the metadata as Draco would, without its stack, which grows by any number a file names.
/// @return  where the metadata end.
std::optional<std::uint64_t> end_of_metadata(const draco::DecoderBuffer& buffer) {
  constexpr std::uint64_t kLeast = 3;  // bytes of an empty nested block: name, entries, blocks
  Ahead ahead(buffer);
  const auto name = [&] { ahead.skip(ahead.fixed<std::uint8_t>()); };
  const auto block = [&](std::uint64_t& pending) {
    for (std::uint64_t entries = ahead.varint(); entries > 0 && ahead.complete(); --entries) {
      name();
      ahead.skip(ahead.varint());
    }
    pending += ahead.varint();
    return ahead.complete() && pending <= ahead.remaining() / kLeast;
  };
  const auto tree = [&] {
    std::uint64_t pending = 0;
    if (!block(pending)) return false;
    while (pending > 0) {
      --pending;
      name();
      if (!block(pending)) return false;
    }
    return true;
  };
  for (std::uint64_t attributes = ahead.varint(); attributes > 0; --attributes) {
    ahead.varint();
    if (!tree()) return std::nullopt;
  }
  if (!tree()) return std::nullopt;
  return ahead.position();
}

/// The file without its metadata, which say nothing about points.
Result<std::vector<std::byte>> without_metadata(std::span<const std::byte> bytes, std::string_view name) {
  draco::DecoderBuffer buffer;
  const std::span<const std::byte> body = bytes.subspan(kHeaderSize);
  buffer.Init(reinterpret_cast<const char*>(body.data()), body.size());
  const std::optional<std::uint64_t> end = end_of_metadata(buffer);
  if (!end) {
    return Error{ErrorCode::malformed_input, std::string(name) + ": the metadata of the Draco file run beyond its " +
                                                 std::to_string(bytes.size()) + " bytes"};
  }
  std::vector<std::byte> plain(bytes.begin(), bytes.begin() + kHeaderSize);
  plain[kFlagsAt + 1] &= ~static_cast<std::byte>(kMetadataFlag >> 8);
  plain.insert(plain.end(), body.begin() + static_cast<std::ptrdiff_t>(*end), body.end());
  return plain;
}

template <class Decoder, class Geometry>
Status run(Budget& budget, std::span<const std::byte> bytes, Geometry* geometry) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const draco::DecoderOptions options;
  Decoder decoder(budget);
  const draco::Status status = decoder.Decode(options, &buffer, geometry);
  if (budget.refusal) return std::move(*budget.refusal);
  if (status.ok()) return Done{};
  return Error{ErrorCode::malformed_input, std::string(budget.name) + ": the Draco file of " +
                                               std::to_string(budget.file_size) + " bytes is damaged or cut off (" +
                                               status.error_msg_string() + ")"};
}

}  // namespace

Result<DracoGeometry> decode_draco(std::span<const std::byte> bytes, std::string_view name, std::uint64_t max_points) {
  const Result<Header> header = read_header(bytes, name);
  if (!header) return header.error();
  Budget budget{name, bytes.size(), max_points, {}};
  std::vector<std::byte> plain;
  if (version(header->major, header->minor) >= version(1, 3) && (header->flags & kMetadataFlag) != 0) {
    Result<std::vector<std::byte>> rewritten = without_metadata(bytes, name);
    if (!rewritten) return std::move(rewritten).error();
    plain = std::move(*rewritten);
    bytes = plain;
  }
  DracoGeometry geometry;
  Status status = Done{};
  if (header->type == draco::POINT_CLOUD) {
    geometry.points = std::make_unique<draco::PointCloud>();
    status = header->method == draco::POINT_CLOUD_SEQUENTIAL_ENCODING
                 ? run<SequentialCloud>(budget, bytes, geometry.points.get())
                 : run<KdTreeCloud>(budget, bytes, geometry.points.get());
  } else {
    auto mesh = std::make_unique<draco::Mesh>();
    status = header->method == draco::MESH_SEQUENTIAL_ENCODING ? run<SequentialMesh>(budget, bytes, mesh.get())
                                                               : run<EdgebreakerMesh>(budget, bytes, mesh.get());
    geometry.mesh = mesh.get();
    geometry.points = std::move(mesh);
  }
  if (!status) return std::move(status).error();
  return geometry;
}

}  // namespace surfaced::io
