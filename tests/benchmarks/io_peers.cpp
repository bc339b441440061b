// SPDX-License-Identifier: GPL-3.0-or-later
#include "benchmarks/io_peers.hpp"

#include <CGAL/IO/read_ply_points.h>
#include <CGAL/Simple_cartesian.h>
#include <draco/io/ply_decoder.h>
#include <draco/point_cloud/point_cloud.h>

#include <fstream>
#include <iterator>
#include <vector>

#include "io/io.hpp"

namespace surfaced::benchmarks {

std::optional<std::size_t> read_with_surfaced(const std::string& path) {
  const Result<RawCloud> cloud = read_cloud(path);
  if (!cloud) return std::nullopt;
  return cloud->size();
}

std::optional<std::size_t> read_with_cgal(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
  if (!CGAL::IO::read_PLY(file, std::back_inserter(points))) return std::nullopt;
  return points.size();
}

std::optional<std::size_t> read_with_draco(const std::string& path) {
  draco::PlyDecoder decoder;
  draco::PointCloud cloud;
  if (!decoder.DecodeFromFile(path, &cloud).ok()) return std::nullopt;
  return cloud.num_points();
}

}  // namespace surfaced::benchmarks
