// SPDX-License-Identifier: GPL-3.0-or-later
// Which side of a surface is its front.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "mesh/mesh.hpp"

namespace surfaced {

enum class FacingRule : std::uint8_t {
  /// By the first that tells: normals, viewpoint, a height field's upper side; else as the mesh is.
  automatic,
  up,
  viewpoint,
  outwards,
  /// The opposite of automatic.
  flip
};

struct FacingOptions {
  FacingRule rule = FacingRule::automatic;
  /// Where the points were measured from.
  std::optional<Point3> viewpoint = std::nullopt;
};

/// What decided which side of a part is its front.
enum class FacingReason : std::uint8_t { normals, viewpoint, up, outwards };
constexpr std::size_t kFacingReasons = 4;

/// How the normals of the vertices fit the faces.
struct NormalsUse {
  /// Vertices of triangles.
  std::size_t vertices = 0;
  /// Of them the share whose normals lie on the side of the faces, each part turned as most of them have it.
  double agreeing = 0;
  /// Whether they decide: four fifths agree.
  bool trusted = false;
  /// Normals that opposed their faces and were turned around.
  std::size_t turned = 0;
  /// Normals made of the faces, because those that came lay along the surface.
  std::size_t computed = 0;
};

struct Facing {
  /// Triangles by what decided for their part.
  std::array<std::size_t, kFacingReasons> triangles{};
  /// Share of the evidence that agrees with the decision, mean over the triangles; none where nothing but the shape
  /// told.
  std::optional<double> certainty{};
  /// Triangles that were turned.
  std::size_t turned = 0;
  /// None without normals.
  std::optional<NormalsUse> normals{};
};

/// Turns every part (triangles connected through vertices) as a whole, by one rule for all, and then the normals of the
/// vertices to the side of the faces around them.
/// @pre   neighbours agree in orientation, and under automatic parts that nothing else tells of face outwards already.
/// @cost  O(V + F).
Facing face(TriangleMesh& mesh, const FacingOptions& options);

}  // namespace surfaced
