// SPDX-License-Identifier: GPL-3.0-or-later
// Where a node of a glTF puts its mesh.
#pragma once

#include <array>

#include "io/gltf_container.hpp"

namespace surfaced::io {

/// x -> linear x + shift.
struct Affine {
  std::array<Point3, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Point3 shift{};

  bool only_shifts() const { return rows == Affine{}.rows; }
  Point3 turn(const Point3& p) const { return {dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)}; }
  Point3 operator()(const Point3& p) const {
    if (shift == Point3{} && only_shifts()) return p;  // adding 0 would turn -0 into 0
    const Point3 turned = only_shifts() ? p : turn(p);
    return {turned[0] + shift[0], turned[1] + shift[1], turned[2] + shift[2]};
  }
  double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }
  /// How normals turn: the matrix of cofactors, whose rows are cross products.
  Affine cofactors() const { return {{cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])}, {}}; }
  /// First `inner`, then this.
  Affine after(const Affine& inner) const {
    Affine result;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        result.rows[r][c] = dot(rows[r], {inner.rows[0][c], inner.rows[1][c], inner.rows[2][c]});
      }
    }
    result.shift = (*this)(inner.shift);
    return result;
  }
};

/// The node's matrix, or its scale, rotation and translation; without the quarter turn that the writer gives a node for
/// UpAxis::z.
/// @throws Refusal
Affine transform_of(const GltfDocument& document, const nlohmann::json& node);

}  // namespace surfaced::io
