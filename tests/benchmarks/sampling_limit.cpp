// SPDX-License-Identifier: GPL-3.0-or-later
// How sparse the points may be: for ε in steps of the local feature size, how often a method gives a closed mesh of the
// right genus and one component through every point: a table, and a plot of it.
//   sampling_limit [RUNS [PLOT.svg]]
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "reconstruction/reconstruction.hpp"
#include "support/known_bodies.hpp"

namespace {

using surfaced::Point3;
using surfaced::testing::KnownBody;

/// A body with the least distance of its surface to its medial axis; for bodies with edges, where that is 0, half of
/// their least thickness.
struct Shape {
  KnownBody body;
  double feature;
};

struct Way {
  std::string name;
  std::string method;
  surfaced::Json parameters;
};

constexpr std::array kEpsilons{0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2};
/// Random points tried for each disk; what they leave uncovered is small against the disk.
constexpr double kDarts = 60;

std::vector<Shape> shapes() {
  using namespace surfaced::testing;
  return {{ellipsoid_body("sphere", {1, 1, 1}), 1},
          {torus_body("torus 0.3", 0.3), 0.3},
          {torus_body("torus 0.5", 0.5), 0.5},
          {knot_body("knot", 0.35), 0.35},
          {box_body("box", {2, 1.4, 1}), 0.5},
          {box_body("thin plate", {2, 1.6, 0.3}), 0.15},
          {ellipsoid_body("ellipsoid", {1, 0.7, 0.45}), 0.2025}};
}

std::vector<Way> ways() {
  return {{"best", "minimum-boundary", {{"variant", "best"}}},
          {"fast", "minimum-boundary", {{"variant", "fast"}}},
          {"paper", "minimum-boundary", {{"variant", "paper"}}},
          {"local-delaunay", "local-delaunay", surfaced::Json::object()},
          {"intrinsic-delaunay", "intrinsic-delaunay", surfaced::Json::object()}};
}

/// No place of the surface is farther from a point than ε times the feature: disks of that radius, thrown until none
/// fits. Uneven: in half of the space disks are half as wide.
std::vector<Point3> sample(const Shape& shape, double epsilon, bool even, std::uint32_t seed) {
  std::mt19937 random(seed);
  const double radius = epsilon * shape.feature;
  const double smallest = even ? radius : radius / 2;
  std::vector<Point3> points;
  const auto darts = static_cast<std::size_t>(kDarts * shape.body.area / (smallest * smallest));
  for (std::size_t dart = 0; dart < darts; ++dart) {
    const Point3 p = shape.body.point(random);
    const double own = even || p[0] + 0.3 * p[1] > 0.2 ? radius : smallest;
    const bool fits = std::ranges::none_of(points, [&](const Point3& q) {
      const Point3 d = surfaced::operator-(p, q);
      return surfaced::dot(d, d) < own * own;
    });
    if (fits) points.push_back(p);
  }
  return points;
}

bool right(const Shape& shape, const Way& way, const std::vector<Point3>& points) {
  const surfaced::MethodInfo* method = *surfaced::find_method(way.method);
  const surfaced::Result<surfaced::Json> parameters = surfaced::check_parameters(*method, way.parameters);
  surfaced::RawCloud raw;
  raw.positions = points;
  const auto cloud = surfaced::make_cloud(raw);
  if (!parameters || !cloud) return false;
  surfaced::Context context(1);
  const auto result = surfaced::run(*cloud, *method, *parameters, context);
  if (!result) return false;
  const surfaced::Topology topology = surfaced::topology_of(result->mesh);
  return topology.closed && topology.components == 1 && topology.genus == shape.body.genus &&
         result->mesh.positions.size() == cloud->size();
}

using Shares = std::array<double, kEpsilons.size()>;

/// One curve for each way, over all shapes and samplings.
void plot(const std::string& path, const std::map<std::string, Shares>& curves) {
  constexpr std::array kColours{"#0072b2", "#56b4e9", "#009e73", "#d55e00", "#cc79a7"};
  std::ofstream file(path);
  file << R"(<svg xmlns="http://www.w3.org/2000/svg" width="640" height="400" font-family="sans-serif" font-size="13">)"
       << "\n<rect width=\"640\" height=\"400\" fill=\"white\"/>\n";
  const auto x = [](double epsilon) {
    return 60 + 400 * (epsilon - kEpsilons.front()) / (kEpsilons.back() - kEpsilons.front());
  };
  const auto y = [](double share) { return 340 - 300 * share; };
  for (const double epsilon : kEpsilons) {
    file << "<text x=\"" << x(epsilon) << "\" y=\"360\" text-anchor=\"middle\">" << epsilon << "</text>\n";
  }
  for (const int percent : {0, 50, 100}) {
    file << "<text x=\"50\" y=\"" << y(percent / 100.0) + 4 << "\" text-anchor=\"end\">" << percent << " %</text>\n"
         << "<line x1=\"60\" x2=\"460\" y1=\"" << y(percent / 100.0) << "\" y2=\"" << y(percent / 100.0)
         << "\" stroke=\"#ccc\"/>\n";
  }
  file << "<text x=\"260\" y=\"385\" text-anchor=\"middle\">ε, in local feature sizes</text>\n";
  std::size_t number = 0;
  for (const auto& [name, shares] : curves) {
    const char* colour = kColours[number % kColours.size()];
    file << "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"" << colour << "\" points=\"";
    for (std::size_t k = 0; k < shares.size(); ++k) file << x(kEpsilons[k]) << ',' << y(shares[k]) << ' ';
    file << "\"/>\n<text x=\"475\" y=\"" << 60 + 22 * number << "\" fill=\"" << colour << "\">" << name << "</text>\n";
    ++number;
  }
  file << "</svg>\n";
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> args(argv + 1, argv + argc);
  const unsigned runs = args.empty() ? 3 : static_cast<unsigned>(std::stoul(args[0]));
  std::map<std::string, Shares> curves;
  std::vector<Shape> all = shapes();
  std::printf("| shape, sampling | method |");
  for (const double epsilon : kEpsilons) std::printf(" %.1f |", epsilon);
  std::printf("\n|---|---|");
  for (std::size_t k = 0; k < kEpsilons.size(); ++k) std::printf("---|");
  std::printf("\n");
  for (const Shape& shape : all) {
    for (const bool even : {true, false}) {
      for (const Way& way : ways()) {
        std::printf("| %s, %s | %s |", shape.body.name.c_str(), even ? "even" : "uneven", way.name.c_str());
        for (std::size_t k = 0; k < kEpsilons.size(); ++k) {
          unsigned good = 0;
          for (std::uint32_t seed = 1; seed <= runs; ++seed) {
            good += right(shape, way, sample(shape, kEpsilons[k], even, seed)) ? 1U : 0U;
          }
          curves[way.name][k] += static_cast<double>(good) / runs / static_cast<double>(2 * all.size());
          std::printf(" %u |", good);
        }
        std::printf("\n");
        std::fflush(stdout);
      }
    }
  }
  if (args.size() > 1) plot(args[1], curves);
  return 0;
}
