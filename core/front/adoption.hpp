// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "front/sewing.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::front {

/// A finished mesh in the terms of the front, so that its edges can be flipped: the star of a vertex is what its
/// triangles make, its normal theirs by area. There are no limits on edges.
class AdoptedMesh {
 public:
  /// Keeps a view of the mesh's positions. Requires at least 3 of them, and an oriented edge-manifold mesh.
  /// @cost  O(V + F); about 100 bytes per vertex.
  AdoptedMesh(const TriangleMesh& mesh, unsigned threads);
  AdoptedMesh(const AdoptedMesh&) = delete;
  AdoptedMesh& operator=(const AdoptedMesh&) = delete;

  Fans& fans() { return fans_; }
  Places& places() { return places_; }

 private:
  BoxTree tree_;
  LocalStars stars_;
  Fans fans_;
  Places places_;
};

}  // namespace surfaced::front
