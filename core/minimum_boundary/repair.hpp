// SPDX-License-Identifier: GPL-3.0-or-later
// Symmetric repair: makes bad vertices good by turning cells either way.
#pragma once

#include <queue>
#include <span>
#include <vector>

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// How far a vertex is from good: an integer, 0 for a good vertex.
struct Defects {
  static constexpr int kOutside = 20;
  static int of(const StarGroups& groups) {
    return (groups.in == 0 ? kOutside : static_cast<int>(groups.in) - 1) +
           (groups.out == 0 ? 0 : static_cast<int>(groups.out) - 1);
  }
};

/// Turns cells while the sum of the defects of their vertices falls: largest fall first, then least gain of
/// Σλ, then the least cell. Keeps the defect of every vertex between calls, and a journal of what it turned.
class Repairer {
 public:
  /// Computes the defects of all vertices.
  Repairer(Labelling& labels, const Criterion& criterion, unsigned threads);

  /// Repairs around all bad vertices; false if cancelled.
  bool repair_all(const Context& context);

  /// Repairs around the bad ones of the given vertices, turning no frozen cell and at most `most` cells.
  /// True if all vertices touched are good then.
  bool repair_around(std::span<const VertexIndex> vertices, std::span<const CellIndex> frozen, std::size_t most);

  /// Turns a cell and keeps the books.
  void turn(CellIndex c);

  /// Cells turned since the journal was cleared; turning them again, in any order, restores the labels.
  const std::vector<CellIndex>& journal() const { return journal_; }
  void clear_journal() { journal_.clear(); }
  void roll_back();

  int defect(VertexIndex v) const { return defects_[v]; }
  /// Per vertex 1 if it is good.
  std::vector<std::uint8_t> good_vertices() const;
  Labelling& labels() { return labels_; }

 private:
  struct Turn {
    int defect;
    std::int64_t energy;
    CellIndex cell;
    friend bool operator<(const Turn& a, const Turn& b) {
      if (a.defect != b.defect) return a.defect > b.defect;
      return a.energy != b.energy ? a.energy > b.energy : a.cell > b.cell;
    }
  };

  int defect_now(VertexIndex v);
  bool improving(CellIndex c, Turn& turn);
  void offer_star(VertexIndex v);
  void offer_neighbours_of(CellIndex c);

  Labelling& labels_;
  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  StarCounter counter_;
  std::vector<int> defects_;
  std::priority_queue<Turn> queue_;
  std::vector<CellIndex> journal_;
  std::span<const CellIndex> frozen_;
};

/// Turns OUT components that are not connected to infinity into IN, and with `islands` also IN components
/// into OUT, wherever no vertex loses its last cell of that label by it.
/// @param in  per cell 1 for IN, 0 for OUT; changed in place.
void clean(const DelaunayComplex& complex, bool islands, std::vector<std::uint8_t>& in);

}  // namespace surfaced::boundary
