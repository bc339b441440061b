// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "front/consensus.hpp"
#include "front/local_stars.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::front {

inline constexpr std::uint32_t kNoVertex = VertexIndex::kNone;

/// Oriented face, or edge.
using Face = std::array<std::uint32_t, 3>;
struct Edge {
  std::uint32_t from;
  std::uint32_t to;
  friend bool operator==(const Edge&, const Edge&) = default;
};

/// Face (v, first, second) as v sees it.
struct Wedge {
  std::uint32_t first;
  std::uint32_t second;
  friend bool operator==(const Wedge&, const Wedge&) = default;
};

/// The wedges of a vertex, to be found by their ends: at a vertex of thousands of faces, in the time of a search.
class WedgeEnds {
 public:
  explicit WedgeEnds(std::span<const Wedge> wedges);

  /// The wedge that begins, or ends, at this vertex; none if there is none.
  const Wedge* from(std::uint32_t first) const;
  const Wedge* to(std::uint32_t second) const;

 private:
  std::span<const Wedge> wedges_;
  /// Of many: their numbers by the first and by the second vertex, then by number. Of few: empty.
  std::vector<std::uint32_t> by_first_;
  std::vector<std::uint32_t> by_second_;
};

/// Where the fans of a vertex begin and end: vertices that only one of its wedges has. Kept from change to change,
/// since a search for them takes the time of a sort.
class OpenEnds {
 public:
  explicit OpenEnds(std::span<const Wedge> wedges);

  void add(const Wedge& wedge);
  void remove(const Wedge& wedge);

  /// First vertices of wedges with none before them, in no order; second ones of wedges with none behind.
  std::span<const std::uint32_t> first() const { return first_; }
  std::span<const std::uint32_t> second() const { return second_; }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> second_;
};

/// What the faces at a vertex look like.
enum class Around : std::uint8_t { nothing, open, closed };

/// The faces of a growing surface, as seen from its vertices. A vertex whose star is settled keeps it as a
/// mask over the star; one that the front works on has its own list of wedges. Invariant: every face is with all
/// three of its vertices; no directed edge has two faces.
class Fans {
 public:
  /// Begins with the given faces of the stars.
  Fans(const LocalStars& stars, FaceMasks faces);

  std::size_t points() const { return stars_.points(); }
  std::size_t faces() const { return face_count_; }

  /// The wedges at v. The span lives until the next change of any vertex.
  std::span<const Wedge> wedges(std::uint32_t v) const;

  /// The same for several threads at a time.
  void copy_wedges(std::uint32_t v, std::vector<Wedge>& wedges) const;

  /// The open ends of a vertex with many wedges; null where a look at each is as good.
  const OpenEnds* open_ends(std::uint32_t v) const;

  /// Third vertex of the face that contains the edge in this direction, or kNoVertex.
  std::uint32_t apex(Edge e) const;
  bool uses(Edge e) const { return apex(e) != kNoVertex; }

  Around around(std::uint32_t v) const;
  /// Number of separate fans and umbrellas at v.
  std::size_t fans(std::uint32_t v) const;
  /// The wedges of the fan at v with the fewest faces; of several the one with the least wedge.
  std::vector<Wedge> smallest_fan(std::uint32_t v) const;

  /// Requires that none of the face's directed edges is used.
  void add(const Face& face);
  /// Requires that the face is there.
  void remove(const Face& face);

  /// Vertices that are not settled, ascending: all that may have an open edge.
  std::vector<std::uint32_t> unsettled() const;

  /// Changes can be taken back: undo(mark()) restores the state at the mark.
  std::size_t mark() const { return journal_.size(); }
  void undo(std::size_t mark);

  /// All faces, least vertex first, sorted.
  std::vector<Triangle> triangles() const;

 private:
  std::vector<Wedge>& own(std::uint32_t v);
  void link(const Face& face);
  void unlink(const Face& face);
  std::vector<std::vector<Wedge>> fans_at(std::uint32_t v) const;
  template <class Visit>
  void visit_settled(std::uint32_t v, Visit&& visit) const;

  const LocalStars& stars_;
  FaceMasks masks_;
  std::vector<std::uint32_t> own_of_;  // per vertex its list in own_, or kNoVertex
  std::vector<std::vector<Wedge>> own_;
  /// Of vertices that have or had many wedges, by their list in own_.
  std::unordered_map<std::uint32_t, OpenEnds> ends_of_;
  std::vector<std::uint32_t> owners_;
  std::size_t face_count_ = 0;
  struct Change {
    Face face;
    bool added;
  };
  std::vector<Change> journal_;
  mutable std::vector<Wedge> seen_;
};

}  // namespace surfaced::front
