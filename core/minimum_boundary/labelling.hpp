// SPDX-License-Identifier: GPL-3.0-or-later
// Inside and outside as a label per Delaunay cell; the surface is where they meet.
#pragma once

#include <cstdint>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::boundary {

/// What the labels around a vertex make of it (Theorem A in docs/methods/minimum-boundary.md).
enum class VertexState : std::uint8_t {
  /// No inside cell touches it: the point would lie outside the surface.
  outside,
  /// No outside cell touches it: the point lies in the volume and not on the surface.
  interior,
  /// Its inside cells are facet-connected and its outside cells are: one umbrella.
  surface,
  /// Anything else: the surface touches itself here.
  pinched,
};

inline bool good(VertexState state) { return state == VertexState::interior || state == VertexState::surface; }

/// Facet-connected groups of the cells around a vertex.
struct StarGroups {
  unsigned in = 0;
  unsigned out = 0;
};

/// IN or OUT for every cell. Infinite cells stay OUT. Where all vertices are good, the facets between IN
/// and OUT form a closed, oriented, embedded manifold with every point on it or inside it (Theorem A).
class Labelling {
 public:
  /// All cells OUT.
  explicit Labelling(const DelaunayComplex& complex) : complex_(&complex), state_(complex.cells(), 0) {}

  const DelaunayComplex& complex() const { return *complex_; }
  bool in(CellIndex c) const { return (state_[c] & kIn) != 0; }
  /// Bit i: side i of the cell lies on the surface.
  unsigned border(CellIndex c) const { return state_[c] >> kBorderShift; }
  bool on_border(SideIndex s) const { return ((border(CellIndex(s / 4)) >> (s % 4)) & 1U) != 0; }

  /// Turns IN into OUT or OUT into IN.
  void flip(CellIndex c) {
    state_[c] ^= static_cast<std::uint8_t>(kIn | 0xFU << kBorderShift);
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      const SideIndex mate = complex_->mate(s);
      state_[mate / 4] ^= static_cast<std::uint8_t>(1U << (kBorderShift + mate % 4));
    }
  }

  /// Sets all labels at once: in[c] nonzero is IN.
  void assign(const std::vector<std::uint8_t>& in, unsigned threads);

  /// @cost  O(cells at v), without memory.
  VertexState state(VertexIndex v) const;

  friend bool operator==(const Labelling& a, const Labelling& b) { return a.state_ == b.state_; }

 private:
  static constexpr unsigned kIn = 1;
  static constexpr unsigned kBorderShift = 4;

  std::size_t cycle_length(VertexIndex v, SideIndex start) const;

  const DelaunayComplex* complex_;
  std::vector<std::uint8_t> state_;
};

/// Counts groups of cells around vertices; keeps a mark per cell between calls.
class StarCounter {
 public:
  explicit StarCounter(const DelaunayComplex& complex) : mark_(complex.cells(), 0) {}
  StarGroups count(const Labelling& labels, VertexIndex v);

 private:
  std::vector<std::uint32_t> mark_;
  std::uint32_t epoch_ = 0;
  std::vector<SideIndex> stack_;
};

/// States of all vertices.
std::vector<VertexState> states_of(const Labelling& labels, unsigned threads);

/// The surface: facets between IN and OUT, turned outwards, sorted; vertices are those of `cloud`.
TriangleMesh surface_of(const Labelling& labels, const PointCloud& cloud);

}  // namespace surfaced::boundary
