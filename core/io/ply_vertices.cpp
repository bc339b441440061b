// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ply_vertices.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "io/scalars.hpp"
#include "io/text.hpp"

namespace surfaced::io {
namespace {

using Names = std::array<std::string_view, 3>;
constexpr Names kPosition{"x", "y", "z"};
constexpr Names kNormal{"nx", "ny", "nz"};
constexpr Names kLongNormal{"normal_x", "normal_y", "normal_z"};
constexpr Names kHarmonics{"f_dc_0", "f_dc_1", "f_dc_2"};
constexpr Names kScale{"scale_0", "scale_1", "scale_2"};
constexpr std::string_view kOpacity = "opacity";
/// The harmonic of degree 0, 1 / (2 √π): a Gaussian's mean colour is 1/2 and this times its coefficient (B. Kerbl, G.
/// Kopanas, T. Leimkühler, G. Drettakis, "3D Gaussian splatting for real-time radiance field rendering", 2023).
constexpr double kHarmonic0 = 0.28209479177387814;
/// Names of colours seen in the field, with that of the opacity beside them.
constexpr auto kColors = std::to_array<std::pair<Names, std::string_view>>({
    {{"red", "green", "blue"}, "alpha"},
    {{"diffuse_red", "diffuse_green", "diffuse_blue"}, "diffuse_alpha"},
    {{"r", "g", "b"}, "a"},
});

Slot after(Slot slot, std::size_t steps) { return static_cast<Slot>(static_cast<std::size_t>(slot) + steps); }

/// Copies one value of every row: T as stored, Out as kept.
template <class T, bool Swapped, class Out>
void gather(const std::byte* rows, std::size_t stride, std::size_t count, Out* out, std::size_t out_stride) {
  for (std::size_t i = 0; i < count; ++i) {
    out[i * out_stride] = static_cast<Out>(load<T, Swapped>(rows + i * stride));
  }
}

template <class Out>
using Gather = void (*)(const std::byte*, std::size_t, std::size_t, Out*, std::size_t);

template <class Out, bool Swapped>
Gather<Out> gather_of(Scalar type) {
  switch (type) {
    case Scalar::int8:
      return gather<std::int8_t, Swapped, Out>;
    case Scalar::uint8:
      return gather<std::uint8_t, Swapped, Out>;
    case Scalar::int16:
      return gather<std::int16_t, Swapped, Out>;
    case Scalar::uint16:
      return gather<std::uint16_t, Swapped, Out>;
    case Scalar::int32:
      return gather<std::int32_t, Swapped, Out>;
    case Scalar::uint32:
      return gather<std::uint32_t, Swapped, Out>;
    case Scalar::float32:
      return gather<float, Swapped, Out>;
    case Scalar::float64:
      break;
  }
  return gather<double, Swapped, Out>;
}

template <class Out>
Gather<Out> gather_of(Scalar type, bool swapped) {
  return swapped ? gather_of<Out, true>(type) : gather_of<Out, false>(type);
}

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::clamp(std::round(value), 0.0, 255.0)); }

}  // namespace

bool VertexLayout::take(const PlyElement& element, Slot first, std::span<const std::string_view> names) {
  std::array<std::optional<std::size_t>, 3> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    found.at(i) = element.find(names[i]);
    if (!found.at(i) || element.properties[*found.at(i)].is_list()) return false;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Slot slot = after(first, i);
    property_[static_cast<std::size_t>(slot)] = found.at(i);
    slots_[*found.at(i)] = slot;
  }
  return true;
}

Result<VertexLayout> VertexLayout::of(const PlyElement& element, std::string_view name, const SplatOptions& splats) {
  VertexLayout layout;
  layout.slots_.assign(element.properties.size(), Slot::none);
  if (!layout.take(element, Slot::x, kPosition)) {
    std::string there;
    for (const PlyProperty& property : element.properties) {
      if (there.size() > 200) break;
      there += (there.empty() ? "" : ", ") + in_quotes(property.name) + (property.is_list() ? " (list)" : "");
    }
    return Error{
        ErrorCode::missing_positions,
        std::string(name) + ": element 'vertex' has the properties [" + there + "]; the scalars x, y and z are needed" +
            (element.find("packed_position")
                 ? std::string("; these are compressed Gaussian splats: export them as PLY without compression")
                 : std::string())};
  }
  layout.take_normals(element);
  layout.take_colors(element);
  layout.take_splats(element, splats);
  return layout;
}

void VertexLayout::take_normals(const PlyElement& element) {
  has_normals_ = take(element, Slot::nx, kNormal) || take(element, Slot::nx, kLongNormal);
  if (!has_normals_ && (element.find("nx") || element.find("ny") || element.find("nz"))) {
    warnings_.emplace_back("normals ignored: not all of nx, ny, nz are there as scalars");
  }
}

void VertexLayout::take_colors(const PlyElement& element) {
  for (const auto& [names, alpha] : kColors) {
    if (!take(element, Slot::red, names)) continue;
    has_colors_ = true;
    take(element, Slot::alpha, std::span(&alpha, 1));
    break;
  }
  if (!has_colors_) take_packed(element);
  if (!has_colors_ && (element.find("red") || element.find("green") || element.find("blue"))) {
    warnings_.emplace_back("colours ignored: not all of red, green, blue are there as scalars");
  }
  for (const Slot slot : {Slot::red, Slot::green, Slot::blue, Slot::alpha}) {
    const auto found = property(slot);
    if (found && element.properties[*found].type != Scalar::uint8) byte_colors_ = false;
  }
}

void VertexLayout::take_packed(const PlyElement& element) {
  for (const std::string_view name : {"rgb", "rgba"}) {
    const auto found = element.find(name);
    if (!found || size_of(element.properties[*found].type) != 4) continue;
    has_colors_ = take(element, Slot::packed, std::span(&name, 1));
    packed_alpha_ = name == "rgba";
    if (has_colors_) return;
  }
}

void VertexLayout::take_splats(const PlyElement& element, const SplatOptions& splats) {
  if (!has_colors_ && take(element, Slot::red, kHarmonics)) {
    has_colors_ = harmonic_colors_ = true;
    byte_colors_ = false;
  }
  const bool filtered = splats.least_opacity || splats.largest_scale;
  const bool gaussians = element.find(kOpacity) && element.find(kScale[0]) && element.find("rot_0");
  if (!gaussians) {
    if (filtered) warnings_.emplace_back("splat_opacity and splat_scale change nothing: the points are no Gaussians");
    return;
  }
  if (splats.least_opacity && take(element, Slot::opacity, std::span(&kOpacity, 1))) {
    splats_.least_opacity = splats.least_opacity;
  }
  if (splats.largest_scale && take(element, Slot::scale0, kScale)) splats_.largest_scale = splats.largest_scale;
  if (filtered) return;
  warnings_.emplace_back(
      "the points are Gaussians: all their centres are taken, also of faint and of large ones; splat_opacity=0.5 and "
      "splat_scale=x leave those out");
}

VertexSink::VertexSink(const PlyElement& element, VertexLayout layout) : layout_(std::move(layout)) {
  std::size_t offset = 0;
  for (const PlyProperty& property : element.properties) {
    types_.push_back(property.type);
    offsets_.push_back(offset);
    offset += size_of(property.type);
  }
}

void VertexSink::reserve(std::size_t count) {
  cloud_.positions.reserve(count);
  if (layout_.has_normals()) cloud_.normals.reserve(count);
  if (!layout_.has_colors()) return;
  if (layout_.byte_colors()) {
    cloud_.colors.reserve(count);
  } else {
    wide_.reserve(count);
  }
}

void VertexSink::push(const VertexRow& row) {
  cloud_.positions.push_back({row[0], row[1], row[2]});
  const auto narrow = [&](Slot slot) { return static_cast<float>(row[static_cast<std::size_t>(slot)]); };
  if (layout_.has_normals()) cloud_.normals.push_back({narrow(Slot::nx), narrow(Slot::ny), narrow(Slot::nz)});
  if (layout_.splats().least_opacity) opacity_.push_back(narrow(Slot::opacity));
  for (std::size_t i = 0; i < 3 && layout_.splats().largest_scale; ++i) {
    scale_.at(i).push_back(narrow(after(Slot::scale0, i)));
  }
  if (!layout_.has_colors()) return;
  if (const auto packed = layout_.property(Slot::packed)) {
    const double value = row[static_cast<std::size_t>(Slot::packed)];
    push_packed(types_[*packed] == Scalar::float32 ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                                   : static_cast<std::uint32_t>(static_cast<std::int64_t>(value)));
    return;
  }
  const auto byte = [&](Slot slot) { return to_byte(row[static_cast<std::size_t>(slot)]); };
  if (layout_.byte_colors()) {
    const std::uint8_t alpha = layout_.has_alpha() ? byte(Slot::alpha) : std::uint8_t{255};
    cloud_.colors.push_back({byte(Slot::red), byte(Slot::green), byte(Slot::blue), alpha});
  } else {
    wide_.push_back(
        {narrow(Slot::red), narrow(Slot::green), narrow(Slot::blue), layout_.has_alpha() ? narrow(Slot::alpha) : 0});
  }
}

void VertexSink::push_rows(const std::byte* rows, std::size_t stride, std::size_t count, bool swapped) {
  const std::size_t first = size();
  const auto fill = [&]<class Out, std::size_t N>(std::vector<std::array<Out, N>>& column, Slot slot, std::size_t width,
                                                  const std::array<Out, N>& value) {
    column.resize(first + count, value);
    for (std::size_t i = 0; i < width; ++i) {
      const auto property = layout_.property(after(slot, i));
      if (!property) continue;
      gather_of<Out>(types_[*property], swapped)(rows + offsets_[*property], stride, count, &column[first][i], N);
    }
  };
  fill(cloud_.positions, Slot::x, 3, {});
  if (layout_.has_normals()) fill(cloud_.normals, Slot::nx, 3, {});
  if (layout_.splats().least_opacity) gather_column(Slot::opacity, rows, stride, count, swapped, opacity_);
  for (std::size_t i = 0; i < 3 && layout_.splats().largest_scale; ++i) {
    gather_column(after(Slot::scale0, i), rows, stride, count, swapped, scale_.at(i));
  }
  if (!layout_.has_colors()) return;
  if (const auto packed = layout_.property(Slot::packed)) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::byte* const at = rows + i * stride + offsets_[*packed];
      push_packed(swapped ? load<std::uint32_t, true>(at) : load<std::uint32_t, false>(at));
    }
    return;
  }
  if (layout_.byte_colors()) {
    fill(cloud_.colors, Slot::red, 4, {0, 0, 0, 255});
  } else {
    fill(wide_, Slot::red, 4, {});
  }
}

bool VertexSink::floating_colors() const {
  for (const Slot slot : {Slot::red, Slot::green, Slot::blue}) {
    const auto property = layout_.property(slot);
    if (property && (types_[*property] == Scalar::float32 || types_[*property] == Scalar::float64)) return true;
  }
  return false;
}

void VertexSink::push_packed(std::uint32_t bits) {
  const auto byte = [&](unsigned shift) { return static_cast<std::uint8_t>(bits >> shift & 255U); };
  cloud_.colors.push_back({byte(16), byte(8), byte(0), layout_.packed_alpha() ? byte(24) : std::uint8_t{255}});
}

void VertexSink::gather_column(Slot slot, const std::byte* rows, std::size_t stride, std::size_t count, bool swapped,
                               std::vector<float>& column) {
  const auto property = layout_.property(slot);
  const std::size_t first = column.size();
  column.resize(first + count);
  gather_of<float>(types_[*property], swapped)(rows + offsets_[*property], stride, count, column.data() + first, 1);
}

/// Keeps the order of the others.
void VertexSink::drop_unwanted_splats() {
  const SplatOptions& wanted = layout_.splats();
  if (!wanted.least_opacity && !wanted.largest_scale) return;
  const auto is_wanted = [&](std::size_t i) {
    // Opacity is kept as its logit, the half-axes as their logarithms.
    if (wanted.least_opacity && !(1 / (1 + std::exp(-static_cast<double>(opacity_[i]))) >= *wanted.least_opacity))
      return false;
    const auto axis = [&](std::size_t k) { return static_cast<double>(scale_.at(k)[i]); };
    return !wanted.largest_scale || std::exp(std::max({axis(0), axis(1), axis(2)})) <= *wanted.largest_scale;
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (!is_wanted(i)) continue;
    cloud_.positions[kept] = cloud_.positions[i];
    if (!cloud_.normals.empty()) cloud_.normals[kept] = cloud_.normals[i];
    if (!cloud_.colors.empty()) cloud_.colors[kept] = cloud_.colors[i];
    ++kept;
  }
  cloud_.warnings.push_back(std::to_string(size() - kept) + " of " + std::to_string(size()) +
                            " Gaussians left out by splat_opacity and splat_scale");
  cloud_.positions.resize(kept);
  if (!cloud_.normals.empty()) cloud_.normals.resize(kept);
  if (!cloud_.colors.empty()) cloud_.colors.resize(kept);
}

RawCloud VertexSink::finish() {
  cloud_.warnings = layout_.warnings();
  if (layout_.harmonic_colors()) {
    for (WideColor& color : wide_) {
      for (std::size_t c = 0; c < 3; ++c) {
        color[c] = static_cast<float>(std::clamp(0.5 + kHarmonic0 * static_cast<double>(color[c]), 0.0, 1.0));
      }
    }
  }
  if (layout_.has_colors() && !layout_.byte_colors()) {
    cloud_.colors = to_bytes(wide_, floating_colors(), layout_.has_alpha(), cloud_.warnings);
  }
  drop_unwanted_splats();
  return std::move(cloud_);
}

}  // namespace surfaced::io
