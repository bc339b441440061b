// SPDX-License-Identifier: GPL-3.0-or-later
// The advancing front that papers 2 and 3 share: normals and local Delaunay stars of all points, the triangles on which
// they agree, and the front that sews the rest; closing and repair of small holes.
#pragma once

#include "front/adoption.hpp"
#include "front/closing.hpp"
#include "front/consensus.hpp"
#include "front/fans.hpp"
#include "front/growing.hpp"
#include "front/local_stars.hpp"
#include "front/seeding.hpp"
#include "front/sewing.hpp"
