// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/base.hpp"
#include "spatial/spatial.hpp"

namespace surfaced::front {

/// How a point's neighbours are laid out in its tangent plane before their 2-D Delaunay star is taken.
enum class StarKind : std::uint8_t {
  restricted,  ///< Voronoi cell of the points in space, cut by the tangent plane
  unfolded,    ///< angles in the plane, distances in space
  projected    ///< paper 2: orthogonal projection
};

struct StarParameters {
  StarKind kind = StarKind::restricted;
  /// Nearest neighbours a star is taken from at first, at least 8.
  std::size_t neighbours = 16;
  /// Whether spacings are kept too.
  bool spacings = false;
};

/// Normals and local Delaunay stars of V points.
///
/// The star of v lists the vertices of its triangles counter-clockwise about the normal: triangle i is
/// (v, star[i], star[i+1]), cyclically where the star is closed. Its vertices are distinct and not v.
class LocalStars {
 public:
  static constexpr std::size_t kLongestStar = 32;

  explicit LocalStars(std::size_t points) : normals(points), headers_(points) {}

  std::size_t points() const { return headers_.size(); }
  std::span<const std::uint32_t> star(std::size_t v) const {
    return {blocks_[v / BoxTree::kPointsPerBlock].data() + headers_[v].start, headers_[v].count};
  }
  bool closed(std::size_t v) const { return headers_[v].closed; }
  /// Number of triangles of the star.
  std::size_t triangles(std::size_t v) const {
    const std::size_t n = headers_[v].count;
    return headers_[v].closed ? n : n - (n > 0 ? 1 : 0);
  }
  /// Turns the normal and the star of v over.
  void turn_over(std::size_t v);

  /// Unit normals by weighted principal components; local coordinates are only scaled, so they hold in the input's.
  std::vector<Normal3> normals;
  /// Distance of the 6th nearest neighbour (local): about the length of a triangle's edge. Empty unless asked for.
  std::vector<float> spacings;

 private:
  friend class StarMaker;
  friend class StarGiver;
  struct Header {
    std::uint16_t start = 0;  // in the block's list
    std::uint8_t count = 0;
    bool closed = false;
  };
  std::vector<Header> headers_;
  /// Per block of BoxTree the stars of its points one after the other.
  std::vector<std::vector<std::uint32_t>> blocks_;
};

/// Normals and stars of all points. Parallel over blocks, the same for any number of threads.
/// @return  cancelled. The tree needs at least 3 points.
/// @cost    O(V); 44 bytes per point kept, 4 more with spacings.
Result<LocalStars> local_stars(const BoxTree& tree, const StarParameters& parameters, Context& context);

}  // namespace surfaced::front
