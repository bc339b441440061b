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

Result<VertexLayout> VertexLayout::of(const PlyElement& element, std::string_view name) {
  VertexLayout layout;
  layout.slots_.assign(element.properties.size(), Slot::none);
  if (!layout.take(element, Slot::x, kPosition)) {
    std::string there;
    for (const PlyProperty& property : element.properties) {
      if (there.size() > 200) break;
      there += (there.empty() ? "" : ", ") + in_quotes(property.name) + (property.is_list() ? " (list)" : "");
    }
    return Error{ErrorCode::missing_positions, std::string(name) + ": element 'vertex' has the properties [" + there +
                                                   "]; the scalars x, y and z are needed"};
  }
  layout.has_normals_ = layout.take(element, Slot::nx, kNormal);
  if (!layout.has_normals_ && (element.find("nx") || element.find("ny") || element.find("nz"))) {
    layout.warnings_.emplace_back("normals ignored: not all of nx, ny, nz are there as scalars");
  }
  for (const auto& [names, alpha] : kColors) {
    if (!layout.take(element, Slot::red, names)) continue;
    layout.has_colors_ = true;
    layout.take(element, Slot::alpha, std::span(&alpha, 1));
    break;
  }
  if (!layout.has_colors_ && (element.find("red") || element.find("green") || element.find("blue"))) {
    layout.warnings_.emplace_back("colours ignored: not all of red, green, blue are there as scalars");
  }
  for (const Slot slot : {Slot::red, Slot::green, Slot::blue, Slot::alpha}) {
    const auto property = layout.property(slot);
    if (property && element.properties[*property].type != Scalar::uint8) layout.byte_colors_ = false;
  }
  return layout;
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
  if (!layout_.has_colors()) return;
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
  if (!layout_.has_colors()) return;
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

RawCloud VertexSink::finish() {
  cloud_.warnings = layout_.warnings();
  if (layout_.has_colors() && !layout_.byte_colors()) {
    cloud_.colors = to_bytes(wide_, floating_colors(), layout_.has_alpha(), cloud_.warnings);
  }
  return std::move(cloud_);
}

}  // namespace surfaced::io
