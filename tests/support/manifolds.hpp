// SPDX-License-Identifier: GPL-3.0-or-later
// What the methods that grow a front promise of every mesh.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "mesh/mesh.hpp"

namespace surfaced::testing {

inline void expect_oriented_manifold(const TriangleMesh& mesh, const std::string& name) {
  const Topology topology = topology_of(mesh);
  EXPECT_TRUE(topology.edge_manifold) << name;
  EXPECT_TRUE(topology.vertex_manifold) << name;
  EXPECT_TRUE(topology.oriented) << name;
  for (const Triangle& t : mesh.triangles) {
    ASSERT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) << name;
    ASSERT_LT(*std::ranges::max_element(t), mesh.positions.size()) << name;
  }
}

}  // namespace surfaced::testing
