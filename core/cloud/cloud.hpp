// SPDX-License-Identifier: GPL-3.0-or-later
// Point clouds: as read (RawCloud) and as every method works on them (PointCloud).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// Points in the order of the file. Invariant: normals and colors are empty or as long as positions.
struct RawCloud {
  std::vector<Point3> positions;
  std::vector<Normal3> normals;
  std::vector<Color4> colors;
  /// What the reader dropped or changed, a sentence each.
  std::vector<std::string> warnings;

  std::size_t size() const { return positions.size(); }
};

/// Distinct points in canonical order: the same for any order of the same input points.
/// A method numbers its vertices like `positions`; `run` drops unused ones (vertices_of_input says where points went).
struct PointCloud {
  /// V distinct finite positions within float32's range, +0 instead of -0; sorted by Morton key on
  /// the bounding cube, then by x, y, z.
  std::vector<Point3> positions;
  /// Empty or V; of duplicates the normalised mean.
  std::vector<Normal3> normals;
  /// Empty or V; of duplicates the mean.
  std::vector<Color4> colors;
  /// N entries: where each input point stands in `positions`.
  std::vector<VertexIndex> input_to_vertex;
  std::vector<std::string> warnings;

  std::size_t size() const { return positions.size(); }
};

/// Validates, merges exact duplicates and sorts.
/// @return  the cloud; coordinate_not_finite or coordinate_out_of_range with the index and value of
///          the first bad point. Normals that are not finite or zero are dropped, all of them, with a warning.
/// @cost    O(N) by radix sort; 32 bytes per point besides the input and the result.
Result<PointCloud> make_cloud(RawCloud raw, unsigned threads = 1);

/// Bounds of the points; {0,0,0},{0,0,0} if there are none.
struct Bounds {
  Point3 low{};
  Point3 high{};
  /// Length of the diagonal.
  double diagonal() const { return norm(high - low); }
};
Bounds bounds_of(const std::vector<Point3>& positions);

}  // namespace surfaced
