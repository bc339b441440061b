// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/inflating.hpp"

#include <algorithm>
#include <array>
#include <queue>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kInflateStride = 1024;

class Inflater {
 public:
  Inflater(Labelling& labels, const FacetSet& boundary, const Criterion& criterion, const VertexTest& passes,
           unsigned threads)
      : labels_(labels),
        complex_(labels.complex()),
        boundary_(boundary),
        criterion_(criterion),
        passes_(passes),
        good_(complex_.points()) {
    parallel_ranges(threads, good_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) good_[v] = passes_(labels_, VertexIndex(v)) ? 1 : 0;
    });
  }

  /// As above, where it is known which vertices pass.
  Inflater(Labelling& labels, const FacetSet& boundary, const Criterion& criterion, const VertexTest& passes,
           std::vector<std::uint8_t> known)
      : labels_(labels),
        complex_(labels.complex()),
        boundary_(boundary),
        criterion_(criterion),
        passes_(passes),
        good_(std::move(known)) {}

  /// Takes candidates in until there are none; false if cancelled.
  bool run(const Context& context) {
    for (std::size_t v = 0; v < good_.size(); ++v) {
      if (good_[v] == 0) offer_star(VertexIndex(v));
    }
    std::size_t steps = 0;
    while (!queue_.empty()) {
      if (++steps % kInflateStride == 0 && context.cancelled()) return false;
      const Candidate best = queue_.top();
      queue_.pop();
      // Costs only fall as facets come to the surface: an entry that costs less was handled before.
      if (is_candidate(best.cell) && cost(best.cell) == best.cost) take_in(best.cell);
    }
    return true;
  }

  /// Fills the star of a vertex that fails without a candidate; false if there is none.
  bool force_one() {
    const auto bad = std::ranges::find(good_, 0);
    if (bad == good_.end()) return false;
    for (const SideIndex corner : complex_.star(VertexIndex(static_cast<std::size_t>(bad - good_.begin())))) {
      const CellIndex c = DelaunayComplex::cell_of(corner);
      if (!labels_.in(c) && !complex_.infinite(c)) take_in(c);
    }
    return true;
  }

  std::size_t taken() const { return taken_; }

 private:
  struct Candidate {
    std::int64_t cost;
    CellIndex cell;
    friend bool operator<(const Candidate& a, const Candidate& b) {
      return a.cost != b.cost ? a.cost > b.cost : a.cell > b.cell;
    }
  };

  bool exists(SideIndex s) const { return boundary_.contains(s) || labels_.on_border(s); }

  bool is_candidate(CellIndex c) const {
    if (labels_.in(c) || complex_.infinite(c)) return false;
    const unsigned existing = boundary_.of_cell(c) | labels_.border(c);
    if (existing == 0) return false;
    for (unsigned i = 0; i < 4; ++i) {
      const bool facet_here = (existing & ~(1U << i)) != 0;
      if (facet_here && good_[complex_.vertex(4 * c + i)] == 0) return true;
    }
    return false;
  }

  std::int64_t cost(CellIndex c) const {
    std::int64_t sum = 0;
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      if (!exists(SideIndex(s))) sum += criterion_.energy(SideIndex(s));
    }
    return sum;
  }

  void offer(CellIndex c) {
    if (is_candidate(c)) queue_.push({cost(c), c});
  }
  void offer_star(VertexIndex v) {
    for (const SideIndex corner : complex_.star(v)) offer(DelaunayComplex::cell_of(corner));
  }

  /// Only the cell's neighbours gain a facet; only its vertices can change their state.
  void take_in(CellIndex c) {
    labels_.flip(c);
    ++taken_;
    std::array<bool, 4> newly_bad{};
    for (std::size_t i = 0; i < 4; ++i) {
      const VertexIndex v = complex_.vertex(4 * c + i);
      const bool before = good_[v] != 0;
      good_[v] = passes_(labels_, v) ? 1 : 0;
      newly_bad[i] = before && good_[v] == 0;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      if (newly_bad[i]) offer_star(complex_.vertex(4 * c + i));
      offer(complex_.neighbour(SideIndex(4 * c + i)));
    }
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
  const FacetSet& boundary_;
  const Criterion& criterion_;
  const VertexTest& passes_;
  std::vector<std::uint8_t> good_;
  std::priority_queue<Candidate> queue_;
  std::size_t taken_ = 0;
};

Error cancelled() { return {ErrorCode::cancelled, "cancelled while inflating"}; }

}  // namespace

Result<std::size_t> inflate_until(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                                  const VertexTest& passes, const Context& context, unsigned threads) {
  Inflater inflater(labels, boundary, criterion, passes, threads);
  if (!inflater.run(context)) return cancelled();
  return inflater.taken();
}

namespace {

const VertexTest kPasses = [](const Labelling& l, VertexIndex v) { return good(l.state(v)); };

Result<Inflated> inflate_to_end(Inflater inflater, const Context& context) {
  Inflated result;
  do {
    const std::size_t before = inflater.taken();
    if (!inflater.run(context)) return cancelled();
    result.cells += inflater.taken() - before;
  } while (inflater.force_one());
  result.forced = inflater.taken() - result.cells;
  return result;
}

}  // namespace

Result<Inflated> inflate(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                         const Context& context, unsigned threads) {
  return inflate_to_end({labels, boundary, criterion, kPasses, threads}, context);
}

Result<Inflated> inflate_known(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                               std::vector<std::uint8_t> good_vertices, const Context& context) {
  return inflate_to_end({labels, boundary, criterion, kPasses, std::move(good_vertices)}, context);
}

}  // namespace surfaced::boundary
