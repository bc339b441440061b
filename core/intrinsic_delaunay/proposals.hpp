// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: where one round of upsampling puts its points.
#pragma once

#include <span>
#include <vector>

#include "intrinsic_delaunay/local_shape.hpp"
#include "intrinsic_delaunay/point_tree.hpp"
#include "intrinsic_delaunay/signature.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::idt {

/// The neighbours that shapes are fitted to.
inline constexpr std::size_t kPatch = 16;

/// The surface of a round as its points see it: for every one the quadric through its neighbours, its curvature, and
/// the signature of its patch. Signatures are made only when asked for.
class Surroundings {
 public:
  /// Keeps views of positions and normals (unit or zero, one per position).
  Surroundings(std::span<const Point3> positions, std::span<const Point3> normals, double epsilon);

  /// The quadric through the points nearest to any place, with that place as origin.
  std::optional<LocalShape> shape_at(const Point3& place) const;
  /// Paper 3's weighted mean of the neighbours of a place, with weights exp(-d²/ε²).
  Point3 gaussian_mean(const Point3& place) const;
  double distance_to_nearest(const Point3& place) const;

  /// Curvatures and signatures of all points, for from_similar_patch.
  void describe_patches(Context& context);
  /// The nearest point to `guess` of the most similar patch, laid over the patch around it; none if no patch fits
  /// within ε/4.
  std::optional<Point3> from_similar_patch(const Point3& guess) const;

 private:
  std::vector<Point3> points_of(std::span<const std::uint32_t> indices) const;
  Point3 up_at(std::span<const std::uint32_t> indices) const;

  std::span<const Point3> positions_;
  std::span<const Point3> normals_;
  double epsilon_;
  PointTree tree_;
  std::vector<LocalShape::Curvature> curvatures_;
  std::vector<Signature> signatures_;
  std::optional<VectorTree<8>> signature_tree_;
};

}  // namespace surfaced::idt
