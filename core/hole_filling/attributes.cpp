// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/attributes.hpp"

#include <algorithm>
#include <cmath>

#include "base/vectors.hpp"
#include "hole_filling/refinement.hpp"

namespace surfaced::filling {

void append_attributes(TriangleMesh& mesh, const BoundaryLoop& loop, const Patch& patch) {
  const std::size_t corners = loop.corners.size();
  if (patch.points.size() == corners) return;
  const auto spread = [&](const auto& value) {
    std::vector<Point3> known;
    for (const VertexIndex v : loop.corners) known.push_back(value(v));
    return spread_harmonically(patch, known);
  };
  if (!mesh.normals.empty()) {
    const auto normals = spread([&](VertexIndex v) -> Point3 {
      const Normal3& n = mesh.normals[v];
      return {n[0], n[1], n[2]};
    });
    for (std::size_t i = corners; i < normals.size(); ++i) {
      const Point3 n = direction_of(normals[i]).value_or(Point3{0, 0, 1});
      mesh.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
    }
  }
  if (mesh.colors.empty()) return;
  const auto colours = spread([&](VertexIndex v) -> Point3 {
    const Color4& c = mesh.colors[v];
    return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
  });
  const auto opacities = spread([&](VertexIndex v) -> Point3 { return {double(mesh.colors[v][3]), 0, 0}; });
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0))); };
  for (std::size_t i = corners; i < colours.size(); ++i) {
    mesh.colors.push_back({byte(colours[i][0]), byte(colours[i][1]), byte(colours[i][2]), byte(opacities[i][0])});
  }
}

}  // namespace surfaced::filling
