// The facets in the order of the paper, sorted only as far as they are asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/criterion.hpp"

namespace surfaced::boundary {

/// Every finite facet once, by ascending λ, ties lexicographically. The facets are dealt into buckets by
/// rounded λ²; a bucket is sorted when the first facet of it is asked for. Algorithm 1 ends long before the
/// longest facets, which are most of a volume's.
class FacetQueue {
 public:
  FacetQueue(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads);

  /// The next facet. Precondition: there is one.
  SideIndex pop() {
    if (next_ == sorted_) sort_next_bucket();
    return facets_[next_++].side;
  }
  /// The facet `ahead` places after the next one if it is already known, else any: for prefetching.
  SideIndex peek(std::size_t ahead) const { return facets_[std::min(next_ + ahead, facets_.size() - 1)].side; }

 private:
  struct Keyed {
    std::uint32_t key;
    SideIndex side;
  };
  void sort_next_bucket();
  void sort_ties(std::size_t begin, std::size_t end);

  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  std::vector<Keyed> facets_;
  std::vector<Keyed> other_;
  /// Ends of the buckets, ascending.
  std::vector<std::size_t> ends_;
  std::size_t bucket_ = 0;
  std::size_t sorted_ = 0;
  std::size_t next_ = 0;
};

}  // namespace surfaced::boundary
