// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a PLY's element 'vertex' on their way into a cloud.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/colors.hpp"
#include "io/io.hpp"
#include "io/ply_header.hpp"

namespace surfaced::io {

/// What a property of a vertex may be to a cloud. `packed`: blue, green, red and opacity in the bytes of an integer, or
/// of a float of the same bits. Of a Gaussian, `opacity` and `scale` are as training has them: a logit, logarithms.
enum class Slot : std::uint8_t {
  x,
  y,
  z,
  nx,
  ny,
  nz,
  red,
  green,
  blue,
  alpha,
  packed,
  opacity,
  scale0,
  scale1,
  scale2,
  none
};
constexpr std::size_t kSlots = static_cast<std::size_t>(Slot::none);

/// One vertex, read value by value.
using VertexRow = std::array<double, kSlots>;

/// Which property fills which slot.
class VertexLayout {
 public:
  /// @return  missing_positions if x, y or z is not there as a scalar.
  static Result<VertexLayout> of(const PlyElement& element, std::string_view name, const SplatOptions& splats = {});

  bool has_normals() const { return has_normals_; }
  bool has_colors() const { return has_colors_; }
  bool has_alpha() const { return property_[static_cast<std::size_t>(Slot::alpha)].has_value(); }
  /// Colours are all uchar: taken as they are.
  bool byte_colors() const { return byte_colors_; }
  /// Colours are the mean of a Gaussian's colours, as coefficients of spherical harmonics.
  bool harmonic_colors() const { return harmonic_colors_; }
  /// Colours lie in one property.
  bool packed_colors() const { return property(Slot::packed).has_value(); }
  /// ... with an opacity.
  bool packed_alpha() const { return packed_alpha_; }
  /// Which of the Gaussians are wanted; nothing where the vertices are none.
  const SplatOptions& splats() const { return splats_; }
  /// Slot of every property of the element.
  const std::vector<Slot>& slots() const { return slots_; }
  std::optional<std::size_t> property(Slot slot) const { return property_[static_cast<std::size_t>(slot)]; }
  /// What was left aside, a sentence each.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  bool take(const PlyElement& element, Slot first, std::span<const std::string_view> names);
  void take_normals(const PlyElement& element);
  void take_colors(const PlyElement& element);
  void take_packed(const PlyElement& element);
  void take_splats(const PlyElement& element, const SplatOptions& splats);

  std::array<std::optional<std::size_t>, kSlots> property_;
  std::vector<Slot> slots_;
  std::vector<std::string> warnings_;
  bool has_normals_ = false;
  bool has_colors_ = false;
  bool byte_colors_ = true;
  bool harmonic_colors_ = false;
  bool packed_alpha_ = false;
  SplatOptions splats_;
};

/// Collects vertices. Colours that are not bytes are kept wide until all are known, since their scale
/// is told by the largest of them.
class VertexSink {
 public:
  VertexSink(const PlyElement& element, VertexLayout layout);

  void reserve(std::size_t count);

  /// One vertex.
  void push(const VertexRow& row);

  /// `count` vertices of `stride` bytes each, without lists.
  void push_rows(const std::byte* rows, std::size_t stride, std::size_t count, bool swapped);

  std::size_t size() const { return cloud_.positions.size(); }
  const VertexLayout& layout() const { return layout_; }

  RawCloud finish();

 private:
  bool floating_colors() const;
  void push_packed(std::uint32_t bits);
  /// A column of its own of every row.
  void gather_column(Slot slot, const std::byte* rows, std::size_t stride, std::size_t count, bool swapped,
                     std::vector<float>& column);
  void drop_unwanted_splats();

  VertexLayout layout_;
  std::vector<Scalar> types_;
  std::vector<std::size_t> offsets_;
  RawCloud cloud_;
  std::vector<WideColor> wide_;
  /// Of Gaussians, where a filter asks for them.
  std::vector<float> opacity_;
  std::array<std::vector<float>, 3> scale_;
};

}  // namespace surfaced::io
