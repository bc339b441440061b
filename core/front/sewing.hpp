// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <queue>
#include <span>
#include <tuple>
#include <vector>

#include "front/fans.hpp"
#include "spatial/spatial.hpp"

namespace surfaced::front {

/// How the angle at a candidate is measured.
enum class Angle : std::uint8_t { spatial, projected };

/// Paper 3: a candidate is no farther from the edge than 2ε.
struct Capsule {
  /// ε in units of the input; none: the spacing at each end.
  std::optional<double> epsilon = std::nullopt;
};

struct SewingParameters {
  Angle angle = Angle::spatial;
  std::optional<Capsule> capsule = std::nullopt;
  /// Nearest neighbours of both ends among which an edge looks for its third vertex.
  std::size_t reach = 32;
  /// Longest edge allowed, in multiples of the spacing at its ends; none: any within reach.
  std::optional<double> max_edge = std::nullopt;
};

/// What the front does and does not do in one pass.
struct Pass {
  /// Least cosine of the angle between the normals of neighbouring faces.
  double least_cosine;
  /// Whether a face may touch a vertex of the front without sharing an edge there.
  bool glue;
  /// Where an edge looks for its third vertex: in the stars of its ends, which are at hand, or among all near points.
  enum class Among : std::uint8_t { stars, near } among = Among::near;
};

/// Positions, normals and neighbourhoods of the points that the front comes to.
class Places {
 public:
  /// With a longest edge or a capsule the stars need their spacings.
  Places(const BoxTree& tree, const LocalStars& stars, const SewingParameters& parameters);

  Point3 position(std::uint32_t v) const { return tree_.local(v); }
  Point3 normal(std::uint32_t v) const;
  /// The local star.
  std::span<const std::uint32_t> star(std::uint32_t v) const { return stars_.star(v); }
  /// Nearest neighbours, ascending by index. The span lives until the next call.
  std::span<const std::uint32_t> neighbours(std::uint32_t v);
  /// Distance of the 6th nearest neighbour. Requires stars with spacings.
  double spacing(std::uint32_t v) const { return static_cast<double>(stars_.spacings[v]); }
  /// Whether the edge is within the longest allowed.
  bool short_enough(std::uint32_t a, std::uint32_t b) const;
  /// Whether the length is within the longest edge allowed at v.
  bool within_longest(double length, std::uint32_t v) const;
  /// Whether c lies in the capsule of the edge ab, where there is one.
  bool in_capsule(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  /// Whether all edges are short enough, and a corner lies in the capsule of the opposite edge.
  bool allows(const Face& face) const;
  std::size_t points() const { return tree_.points(); }
  Angle angle() const { return parameters_.angle; }

 private:
  std::size_t list_of(std::uint32_t v);

  const BoxTree& tree_;
  const LocalStars& stars_;
  SewingParameters parameters_;
  NeighbourSearch search_;
  Neighbours found_;
  std::vector<std::uint32_t> list_of_;  // per vertex where its list begins, or kNoVertex
  std::vector<std::uint32_t> lists_;    // count, then the neighbours
};

/// Area normal of the face: twice its area long.
Point3 area_normal(const Places& places, const Face& face);
/// Infinite where the face has no area.
double circumradius(const Places& places, const Face& face);
/// Cosine of the angle between two vectors; -1 where one has no length.
double cosine(const Point3& a, const Point3& b);

/// Whether the face may be added to the fans as they are: unused directed edges, no vertex closed twice, no
/// folding over the fans in the tangent plane at any corner, no sharper edge than the cosine allows.
bool legal(const Fans& fans, const Places& places, const Face& face, double least_cosine);

/// The open edges at v: those whose face on the other side is missing, in the direction that face would have.
void open_edges(const Fans& fans, std::uint32_t v, std::vector<Edge>& edges);

/// The open edge that follows e on the rim of the hole to its left.
Edge next_open(const Fans& fans, const Places& places, Edge e);

/// Paper 2's advancing front: every open edge has one candidate, the vertex that sees it under the largest
/// angle; the edge with the smallest circumradius, enlarged by the bend, goes first.
class Front {
 public:
  Front(Fans& fans, Places& places) : fans_(fans), places_(places) {}

  /// Advances from all open edges until nothing more is legal.
  /// @return  the number of faces added, or cancelled.
  Result<std::size_t> advance(const Pass& pass, Context& context);
  /// The same from the open edges at the given vertices.
  Result<std::size_t> advance(const Pass& pass, std::span<const std::uint32_t> from, Context& context);

 private:
  struct Entry {
    double key;
    Edge edge;
    std::uint32_t apex;
    /// The queue's top is the least key, then the least edge.
    friend bool operator<(const Entry& a, const Entry& b) {
      if (a.key != b.key) return a.key > b.key;
      return std::tie(a.edge.from, a.edge.to, a.apex) > std::tie(b.edge.from, b.edge.to, b.apex);
    }
  };
  std::optional<Entry> candidate(Edge e);
  void consider(Edge e);
  bool fits(const Entry& entry, const Pass& pass) const;
  double apex_cotangent(const Point3& a, const Point3& b, const Point3& c, const Point3& up) const;

  Fans& fans_;
  Places& places_;
  Pass::Among among_ = Pass::Among::near;
  std::priority_queue<Entry> queue_;
  std::vector<std::uint32_t> near_;
  std::vector<Edge> edges_;
};

}  // namespace surfaced::front
