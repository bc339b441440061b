// SPDX-License-Identifier: GPL-3.0-or-later
// Links the library: points made here, a mesh through them, its quality from the file that was written.
//   mesh_of_points MESH.glb [METHOD]
#include <cmath>
#include <iostream>
#include <numbers>
#include <surfaced/surfaced.hpp>

namespace {

/// Nearly even points on a unit sphere: a Fibonacci spiral.
surfaced::RawCloud sphere(int count) {
  surfaced::RawCloud cloud;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    const double r = std::sqrt(1 - z * z);
    cloud.positions.push_back({r * std::cos(golden * i), r * std::sin(golden * i), z});
  }
  return cloud;
}

/// Errors are values: each step gives its result, or says what, where, and the limit.
surfaced::Status mesh_of_points(const std::string& path, const std::string& method_id) {
  const auto cloud = surfaced::make_cloud(sphere(2000));
  if (!cloud) return cloud.error();
  const auto method = surfaced::find_method(method_id);
  if (!method) return method.error();
  const auto parameters = surfaced::check_parameters(**method, surfaced::Json::object());
  if (!parameters) return parameters.error();

  // Two threads, and a word about every stage; a third argument would let another thread stop it.
  std::string last;
  surfaced::Context context(2, [&last](double share, std::string_view stage) {
    if (stage != last) std::cerr << static_cast<int>(100 * share) << " % " << stage << "\n";
    last = stage;
  });
  const auto made = surfaced::run(*cloud, **method, *parameters, context);
  if (!made) return made.error();
  const auto bytes = surfaced::encode_mesh(made->mesh, surfaced::MeshFormat::glb);
  if (!bytes) return bytes.error();
  if (auto written = surfaced::write_file(path, *bytes); !written) return written;

  const auto report = surfaced::measure_file(path, std::nullopt, true, context);
  if (!report) return report.error();
  const auto& mesh = report->at("mesh");
  std::cout << mesh.at("vertices") << " vertices, " << mesh.at("triangles")
            << " triangles, closed: " << mesh.at("closed") << ", genus " << mesh.at("genus") << "\n";
  return surfaced::Done{};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: mesh_of_points MESH.glb [METHOD]\n";
    return 2;
  }
  const auto done = mesh_of_points(argv[1], argc > 2 ? argv[2] : "minimum-boundary");
  if (!done) std::cerr << "mesh_of_points: " << done.error().detail << "\n";
  return done ? 0 : 1;
}
