// SPDX-License-Identifier: GPL-3.0-or-later
// Stages before a method: outliers, sampling, smoothing, normals. Each takes a cloud and gives a cloud. And what
// methods ask of any cloud: its spacing, a frame for computing, nearest points.
#pragma once

#include <optional>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"

namespace surfaced {

/// Median over the points of their mean distance to the 6 nearest others: what "spacing" means here. 0 for one point.
/// @cost  O(V log V).
double spacing_of(const std::vector<Point3>& positions, unsigned threads);

/// Points that repeat within a tolerance, as several scans of one thing have them.
struct NearRepeats {
  /// Farther apart than those that repeat, nearer than the others.
  double tolerance = 0;
  /// Medians of the distance to the next point that repeats, and to the next that does not.
  double near = 0;
  double far = 0;
  /// Share of the points that have such a neighbour.
  double share = 0;
};

/// Two scales of neighbour distance with nothing between them, if there are: at least a tenth of the points repeat.
/// @param positions  in the order of a PointCloud. At most 4,096 of them are looked at.
/// @cost  O(1) beyond some thousand points.
std::optional<NearRepeats> near_repeats_of(const std::vector<Point3>& positions);

/// Coordinates that were rounded to float32 far from the origin.
struct FloatSteps {
  /// The coarsest step of the axes, and the spacing of the points.
  double step = 0;
  double spacing = 0;
};

/// Whether the coordinates of an axis lie on the steps of float32 at their magnitude, and the steps are no less than
/// 1/32 of the spacing.
/// @cost  O(V); a search for the spacing only where they do.
std::optional<FloatSteps> float_steps_of(const std::vector<Point3>& positions, unsigned threads);

/// Whether the points lie on a line but for what rounding moves them, two steps on every axis: to float32, if it holds
/// all coordinates, or else to a number of decimals that all have. A line is a thousand steps long.
/// @cost  O(V); one pass if they are no line.
bool on_a_rounded_line(const std::vector<Point3>& positions);

/// Where code computes that has absolute thresholds, or that may not lose digits to a far-off origin: the least corner
/// of the points is the origin, and a power of two brings the longest side of their box to [512, 1024). Local points
/// lie on the grid of a double's step at 1024: two are the same or a step apart, so that no product of their distances
/// that geometry code forms is too small for a double. Points that differ by less are one.
class LocalFrame {
 public:
  explicit LocalFrame(const std::vector<Point3>& positions);

  Point3 to_local(const Point3& p) const;
  double to_local(double length) const;
  Point3 to_input(const Point3& local) const;

 private:
  static constexpr int kExtentExponent = 10;
  /// Steps in a unit, as a power of two; 1024 of them need the 53 bits of a double.
  static constexpr int kStepExponent = 43;

  Point3 origin_;
  int exponent_;
};

/// For every place the nearest of the points, and how far it is.
struct Nearest {
  std::vector<VertexIndex> index;
  std::vector<double> distance;
};
/// @param positions  at least one. Of points equally near it is always the same one.
/// @cost  O((V + places) log V).
Nearest nearest_points(const std::vector<Point3>& positions, const std::vector<Point3>& places, unsigned threads);

/// Removes the points whose mean distance to their 12 nearest exceeds `factor` times the median of it.
Result<PointCloud> without_outliers(const PointCloud& cloud, double factor, Context& context);

/// Merges the points within `tolerance` of the first point that is left, in the order of the cloud, into their mean, in
/// which each counts as often as the input has it; normals and colours likewise.
/// @param tolerance  above 0, in units of the input.
/// @cost  O(V log V).
Result<PointCloud> fused(const PointCloud& cloud, double tolerance, Context& context);

/// Keeps one input point in every cell of a grid, the nearest to the cell's centre; `cell` is the side of a cell, in
/// units of the input, or without it twice the spacing; points that repeat within a tolerance count once in that.
Result<PointCloud> sampled(const PointCloud& cloud, std::optional<double> cell, Context& context);

/// Keeps about `share` of the points: one in each cluster of 1 / share points at most, the nearest to its centre.
Result<PointCloud> clustered(const PointCloud& cloud, double share, Context& context);

/// Draws `share` of the points and spreads them evenly over the surface that the others suggest (WLOP). The points
/// move; normals and colours are those of the nearest input point.
/// @cost  35 rounds of searches within some spacings: a hundred times that of the others.
Result<PointCloud> consolidated(const PointCloud& cloud, double share, Context& context);

/// How points are smoothed: onto quadrics, or along normals so that edges stay.
enum class Smoothing : std::uint8_t { jet, bilateral };

/// Moves every point towards the surface through its nearest neighbours. Normals and colours go with the points. More
/// neighbours smooth more; fewer than 7 points stay as they are.
Result<PointCloud> smoothed(const PointCloud& cloud, Smoothing way, std::size_t neighbours, Context& context);

/// How normals are estimated: from the plane, or from the quadric, that fits the neighbours best.
enum class NormalFit : std::uint8_t { plane, jet };

/// Gives every point a normal fitted to its nearest neighbours, turned to agree with that of its neighbours; in each
/// connected part of the cloud the highest point (in z, then y, then x) faces up. So normals of a closed surface face
/// outwards. Normals that the cloud has are replaced.
/// @cost  O(V log V), sequential but for the orientation's search; 16 bytes per point and neighbour.
Result<PointCloud> with_normals(const PointCloud& cloud, NormalFit fit, std::size_t neighbours, Context& context);

}  // namespace surfaced
