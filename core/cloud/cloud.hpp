// SPDX-License-Identifier: GPL-3.0-or-later
// Point clouds: as read (RawCloud) and as every method works on them (PointCloud).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// How a table of text was taken.
struct TableFacts {
  /// What every column was taken for: x, y, z, nx, ny, nz, r, g, b, or - for one that was left.
  std::vector<std::string> columns;
  /// blank, tab, comma, semicolon or bar.
  std::string separator;
  /// point or comma.
  std::string decimal;
  /// Lines before the table that were passed over.
  std::size_t skipped = 0;
  /// Whether any of this was guessed from the values, and not named by a header or by the caller.
  bool guessed = false;
};

/// What a reader knows of the file besides its points.
struct CloudSource {
  /// PLY, LAS, text and so on; with what it was packed in: "PLY in gzip".
  std::string format;
  std::optional<TableFacts> table;
  /// Faces, of any number of corners, that a cloud has no use for.
  std::uint64_t faces = 0;
  /// Where the sensor stood, if the file tells.
  std::optional<Point3> viewpoint{};
};

/// Points in the order of the file. Invariant: normals and colors are empty or as long as positions.
struct RawCloud {
  std::vector<Point3> positions;
  std::vector<Normal3> normals;
  std::vector<Color4> colors;
  /// What the reader dropped or changed, a sentence each.
  std::vector<std::string> warnings;
  CloudSource source{};

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
  /// N entries: where each input point stands in `positions`; none for one without a measurement.
  std::vector<VertexIndex> input_to_vertex;
  std::vector<std::string> warnings;
  CloudSource source{};
  /// Input points left out because they have no measurement.
  std::size_t missing = 0;

  std::size_t size() const { return positions.size(); }
};

/// What becomes of points without a measurement: those with a coordinate that is not finite, and points at exactly 0 0
/// 0 if they are many and lie off all others, as depth cameras write them.
enum class Missing : std::uint8_t {
  /// They are left out, with a warning that counts them.
  drop,
  /// A coordinate that is not finite is an error, 0 0 0 a point as any other.
  refuse
};

/// Validates, merges exact duplicates and sorts.
/// @return  the cloud; coordinate_not_finite (with Missing::drop, only if no point is left) or coordinate_out_of_range,
///          with the index and value of the first bad point. Normals that are not finite or zero are dropped, all of
///          them, with a warning.
/// @cost    O(N) by radix sort; 32 bytes per point besides the input and the result.
Result<PointCloud> make_cloud(RawCloud raw, unsigned threads = 1, Missing missing = Missing::refuse);

/// Bounds of the points; {0,0,0},{0,0,0} if there are none.
struct Bounds {
  Point3 low{};
  Point3 high{};
  /// Length of the diagonal.
  double diagonal() const { return norm(high - low); }
};
Bounds bounds_of(const std::vector<Point3>& positions);

}  // namespace surfaced
