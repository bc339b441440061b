// SPDX-License-Identifier: GPL-3.0-or-later
// What a stranger's first program does: points in, a mesh out, and which point became which vertex where some are
// dropped.
#include <surfaced/surfaced.hpp>

#include <cmath>
#include <iostream>

int main() {
  surfaced::RawCloud raw;
  for (int i = 0; i < 300; ++i) {
    const double z = 1 - (2 * i + 1.0) / 300;
    const double r = std::sqrt(1 - z * z);
    raw.positions.push_back({r * std::cos(2.4 * i), r * std::sin(2.4 * i), z});
  }
  const std::vector<surfaced::Point3> points = raw.positions;
  const auto cloud = surfaced::make_cloud(std::move(raw));
  if (!cloud) return std::cerr << cloud.error().detail << "\n", 1;
  const auto method = surfaced::find_method("minimum-boundary");
  if (!method) return std::cerr << method.error().detail << "\n", 1;
  const auto parameters = surfaced::check_parameters(**method, surfaced::Json{{"sample", "grid"}});
  if (!parameters) return std::cerr << parameters.error().detail << "\n", 1;
  surfaced::Context context;
  const auto made = surfaced::run(*cloud, **method, *parameters, context);
  if (!made) return std::cerr << made.error().detail << "\n", 1;
  const std::vector<surfaced::VertexIndex> of_input = surfaced::vertices_of_input(*cloud, made->mesh);
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const surfaced::VertexIndex v = of_input[i];
    if (!v.valid()) continue;
    ++vertices;
    if (made->mesh.positions[v] != points[i]) return std::cerr << "point " << i << " is not vertex " << v << "\n", 1;
  }
  if (vertices != made->mesh.positions.size() || vertices >= points.size()) {
    return std::cerr << vertices << " points are vertices, of " << made->mesh.positions.size() << "\n", 1;
  }
  return surfaced::topology_of(made->mesh).closed ? 0 : 1;
}
