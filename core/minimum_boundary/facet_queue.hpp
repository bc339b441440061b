// SPDX-License-Identifier: GPL-3.0-or-later
// The facets in the order of the paper, sorted only as far as they are asked for.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/criterion.hpp"

namespace surfaced::boundary {

/// A facet by one of its sides, with its vertices, ascending.
struct ListedFacet {
  SideIndex side;
  std::array<VertexIndex, 3> vertices;
};

/// Every finite facet once, in the order of Criterion::less. The facets are dealt into buckets by
/// rounded λ²; a bucket is sorted when the first facet of it is asked for. Algorithm 1 ends long before the
/// longest facets, which are most of a volume's.
class FacetQueue {
 public:
  FacetQueue(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads);

  /// The next facets, at least one; valid until the next call. Whole blocks, because the order by length jumps
  /// about in memory: looking up many facets in one loop hides the waits behind each other.
  /// Precondition: not all facets have been given out.
  std::span<const ListedFacet> next_block();

 private:
  struct Keyed {
    std::uint32_t key;
    SideIndex side;
  };
  void sort_next_bucket();
  void sort_ties(std::span<ListedFacet> facets);

  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  std::vector<Keyed> facets_;
  std::vector<Keyed> other_;
  /// Ends of the buckets, ascending.
  std::vector<std::size_t> ends_;
  std::size_t bucket_ = 0;
  std::size_t sorted_ = 0;
  std::size_t next_ = 0;
  std::vector<ListedFacet> block_;
  std::vector<std::pair<std::array<double, 3>, ListedFacet>> ties_;
};

}  // namespace surfaced::boundary
