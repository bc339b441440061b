// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest neighbours of the points of a cloud, by runs of its own order: no tree of points is built.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"

namespace surfaced {

/// Boxes over runs of consecutive points (the leaves) and over pairs of boxes. It relies on the order of a
/// PointCloud, in which near indices mean near places; any order is correct.
///
/// Works in local coordinates: the point minus the least corner of the bounding box, times a power of two
/// that brings the box to a size within [1, 2). So squared distances fit a float at any unit.
class BoxTree {
 public:
  /// Leaves never cross a multiple of this many points, so that work can be cut there.
  static constexpr std::size_t kPointsPerBlock = 1024;
  static constexpr std::size_t kLargestLeaf = 16;

  /// Keeps a view of the positions.
  /// @cost  O(V); 7 bytes per point.
  BoxTree(std::span<const Point3> positions, unsigned threads);

  std::size_t points() const { return positions_.size(); }
  std::size_t leaves() const { return first_.size() - 1; }
  std::size_t blocks() const { return block_leaf_.size() - 1; }
  /// Leaves first_leaf(b) .. first_leaf(b+1)-1 make up block b.
  std::size_t first_leaf(std::size_t block) const { return block_leaf_[block]; }
  /// Points first_point(l) .. first_point(l+1)-1 make up leaf l.
  std::size_t first_point(std::size_t leaf) const { return first_[leaf]; }

  Point3 local(std::size_t v) const {
    const Point3& p = positions_[v];
    return {(p[0] - low_[0]) * scale_, (p[1] - low_[1]) * scale_, (p[2] - low_[2]) * scale_};
  }
  /// Local unit in units of the input.
  double scale() const { return scale_; }

  /// Closed box in local coordinates, rounded outwards.
  struct alignas(16) Box {
    std::array<float, 4> low;
    std::array<float, 4> high;
  };
  const Box& leaf_box(std::size_t leaf) const { return levels_.front()[leaf]; }
  Box box_of(const Point3& local) const;

  /// Appends the leaves whose boxes come within `radius` (local) of the box, ascending.
  void leaves_near(const Box& box, float radius, std::vector<std::uint32_t>& leaves) const;

 private:
  void cut_leaves(unsigned threads);
  void build_boxes(unsigned threads);

  std::span<const Point3> positions_;
  Point3 low_{};
  double scale_ = 1;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> block_leaf_;
  /// levels_[0] the leaves; box i of a level holds boxes 2i and 2i+1 of the level below.
  std::vector<std::vector<Box>> levels_;
};

/// Neighbours of one point, ascending by index, relative to it, in local coordinates. Lanes beyond `count` up
/// to the next multiple of 4 hold zeros.
struct Neighbours {
  std::size_t count = 0;
  /// Every point nearer than the root of this is among them (squared, local).
  double covered2 = 0;
  std::vector<std::uint32_t> index;
  std::vector<double> x, y, z, distance2;
};

/// Exact nearest neighbours; the order among them is by (squared distance rounded to float, index), so
/// the result is defined also where distances tie. One per thread: it keeps what it gathered around a place.
class NeighbourSearch {
 public:
  explicit NeighbourSearch(const BoxTree& tree) : tree_(tree) {}

  /// Points of the same leaf one after the other share what was gathered. Start of a leaf: gathers what
  /// is likely to be enough for `k` neighbours of its points.
  void begin_leaf(std::size_t leaf, std::size_t k);

  /// The k nearest of v, which lies in the leaf begun, without v itself; all others if there are fewer.
  void nearest(std::size_t v, std::size_t k, Neighbours& result);

  /// All points gathered that lie within the radius for which gathering is complete at v.
  void gathered(std::size_t v, Neighbours& result);

  /// The k nearest of any point v of the cloud, wherever the search stands; a leaf has to be begun anew afterwards.
  void nearest_anywhere(std::size_t v, std::size_t k, Neighbours& result);

  /// Forgets what was learnt about the spacing from earlier leaves.
  void reset() { expected_radius_ = 0; }

 private:
  void gather(const BoxTree::Box& box, float radius);
  bool try_nearest(std::size_t v, std::size_t k, float limit2, Neighbours& result);
  bool complete() const { return gathered_ == tree_.points(); }
  float grown_radius(std::size_t v, std::size_t k) const;
  void keep(std::size_t v, const Point3& q, std::size_t candidate, Neighbours& result) const;

  const BoxTree& tree_;
  BoxTree::Box box_{};
  float radius_ = 0;
  float expected_radius_ = 0;
  float largest_ = 0;
  double previous_distance_ = -1;
  Point3 previous_{};
  std::size_t gathered_ = 0;
  std::vector<std::uint32_t> near_leaves_;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;
  std::vector<float> distance2_;
  std::vector<std::uint32_t> hits_;
  std::vector<float> hit_distance2_;
};

}  // namespace surfaced
