// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "front/local_stars.hpp"

namespace surfaced::front {

/// Which triangles of the stars are faces: bit i of faces[v] stands for triangle i of the star of v. A face
/// has its bit in the masks of all three vertices.
///
/// An edge va of a face lies in the star of v, where at most two triangles touch a: so no edge has more
/// than two faces, and the faces at a vertex form chains or one full cycle. Manifold without a test.
using FaceMasks = std::vector<std::uint32_t>;

/// The triangles on which the stars of all three vertices agree. Parallel.
FaceMasks agreed_faces(const LocalStars& stars, unsigned threads);

/// Turns normals and stars so that neighbours agree, first across faces, then across triangles that two stars
/// share, then along the edges of stars, the most parallel normals first. Faces that would make the surface
/// one-sided are dropped. Afterwards face (v, star[i], star[i+1]) is that face's orientation at all its vertices.
/// @return  how many faces were dropped.
std::size_t orient(LocalStars& stars, FaceMasks& faces);

}  // namespace surfaced::front
