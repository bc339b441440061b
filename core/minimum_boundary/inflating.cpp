#include "minimum_boundary/inflating.hpp"

#include <algorithm>
#include <queue>

namespace surfaced::boundary {
namespace {

constexpr std::size_t kCancelStride = 1024;

class Inflater {
 public:
  Inflater(Labelling& labels, const FacetSet& boundary, const Criterion& criterion, unsigned threads)
      : labels_(labels),
        complex_(labels.complex()),
        boundary_(boundary),
        criterion_(criterion),
        states_(states_of(labels, threads)) {}

  Result<Inflated> run(const Context& context) {
    for (std::size_t v = 0; v < states_.size(); ++v) {
      if (!good(states_[v])) offer_star(VertexIndex(v));
    }
    std::size_t steps = 0;
    for (;;) {
      while (!queue_.empty()) {
        if (++steps % kCancelStride == 0 && context.cancelled()) {
          return Error{ErrorCode::cancelled, "cancelled while inflating"};
        }
        const Candidate best = queue_.top();
        queue_.pop();
        // Costs only fall as facets come to the surface: an entry that costs less was handled before.
        if (is_candidate(best.cell) && cost(best.cell) == best.cost) {
          take_in(best.cell);
          ++result_.cells;
        }
      }
      if (!force_one()) return result_;
    }
  }

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
      if (facet_here && !good(states_[complex_.vertices[4 * c + i]])) return true;
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
    std::array<bool, 4> newly_bad{};
    for (std::size_t i = 0; i < 4; ++i) {
      const VertexIndex v = complex_.vertices[4 * c + i];
      const VertexState before = states_[v];
      states_[v] = labels_.state(v);
      newly_bad[i] = good(before) && !good(states_[v]);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      if (newly_bad[i]) offer_star(complex_.vertices[4 * c + i]);
      offer(complex_.neighbour(SideIndex(4 * c + i)));
    }
  }

  /// Fills the star of a vertex that is bad without a candidate.
  bool force_one() {
    const auto bad = std::ranges::find_if_not(states_, good);
    if (bad == states_.end()) return false;
    for (const SideIndex corner : complex_.star(VertexIndex(static_cast<std::size_t>(bad - states_.begin())))) {
      const CellIndex c = DelaunayComplex::cell_of(corner);
      if (labels_.in(c) || complex_.infinite(c)) continue;
      take_in(c);
      ++result_.forced;
    }
    return true;
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
  const FacetSet& boundary_;
  const Criterion& criterion_;
  std::vector<VertexState> states_;
  std::priority_queue<Candidate> queue_;
  Inflated result_;
};

}  // namespace

Result<Inflated> inflate(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                         const Context& context, unsigned threads) {
  return Inflater(labels, boundary, criterion, threads).run(context);
}

}  // namespace surfaced::boundary
