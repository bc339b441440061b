// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

namespace surfaced {

/// Position in a flat array of one kind of thing: a VertexIndex cannot be passed for a
/// TriangleIndex. Subscripts an array as it is; made from a number only explicitly.
template <class Tag>
struct Index {
  std::uint32_t value = kNone;

  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  constexpr Index() = default;
  constexpr explicit Index(std::size_t position) : value(static_cast<std::uint32_t>(position)) {}

  /// True unless default-constructed.
  constexpr bool valid() const { return value != kNone; }
  constexpr operator std::size_t() const { return value; }
  friend constexpr auto operator<=>(Index a, Index b) { return a.value <=> b.value; }
  friend constexpr bool operator==(Index a, Index b) { return a.value == b.value; }
};

using VertexIndex = Index<struct VertexTag>;
using TriangleIndex = Index<struct TriangleTag>;
/// Half-edge 3t+i runs from corner i to corner i+1 of triangle t.
using HalfEdgeIndex = Index<struct HalfEdgeTag>;

}  // namespace surfaced
