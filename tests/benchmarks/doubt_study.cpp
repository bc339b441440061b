// SPDX-License-Identifier: GPL-3.0-or-later
// Evidence and truth for clouds of known topology: a line of comma-separated values for each run, from which
// doubt_fit.py makes the coefficients of doubt.cpp.
//   doubt_study FIRST_SEED LAST_SEED [KIND|all [NAME|all]]
// Kinds: part (random parts of clouds), vertices (all of them), mesh (random points of the meshes), body (known
// bodies with noise), even (known bodies, disks that keep their distance), several (bodies side by side).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "io/io.hpp"
#include "minimum_boundary/minimum_boundary.hpp"
#include "support/known_bodies.hpp"

namespace {

using surfaced::Point3;
using surfaced::testing::KnownBody;
using surfaced::testing::random_unit;

struct Truth {
  std::int64_t genus = 0;
  std::size_t components = 1;
  /// 0 where it is not known.
  double volume = 0;
};

struct Model {
  std::string name;
  std::int64_t genus;
};

const std::vector<Model> kModels{{"bunny", 0},    {"fandisk", 0},    {"anchor", 4}, {"fertility", 4}, {"knight", 0},
                                 {"elephant", 0}, {"max_planck", 0}, {"igea", 0},   {"octopus", 0}};
/// A volume beyond this share of the truth is a wrong body.
constexpr double kWrongVolume = 0.25;
constexpr double kNone = 99;

double capped(double x) { return std::isfinite(x) ? std::min(x, kNone) : kNone; }

void print_header() {
  std::printf(
      "kind,name,setting,seed,points,right,genus,components,interior,agreeing,more,fewer,gap,volume_gap,guided,guide,"
      "open,unused,"
      "shared,"
      "opposed,median,high,above,margin,thin,buried,sheets,parts,bodies,outliers,doubt,energy,warnings\n");
}

void run_one(const std::string& kind, const std::string& name, const std::string& setting, std::uint32_t seed,
             const std::vector<Point3>& points, const Truth& truth) {
  surfaced::RawCloud raw;
  raw.positions = points;
  surfaced::Context context(1);
  surfaced::MinimumBoundaryParameters parameters;
  const auto cloud = surfaced::make_cloud(raw);
  const auto result = surfaced::minimum_boundary(*cloud, parameters, context);
  if (!result) return;
  const auto& s = result->statistics;
  const double volume = surfaced::testing::volume_of(result->mesh);
  const bool right = s.genus == truth.genus && s.components == truth.components &&
                     (truth.volume == 0 || std::abs(volume / truth.volume - 1) < kWrongVolume);
  const auto n = static_cast<double>(cloud->size());
  const auto share = [&](std::size_t count) { return static_cast<double>(count) / n; };
  std::string warnings;
  for (const std::string& w : result->warnings) warnings += w.substr(0, w.find(':')) + " ";
  const surfaced::MinimumBoundaryEvidence e = s.evidence.value_or(surfaced::MinimumBoundaryEvidence{});
  std::printf(
      "%s,%s,%s,%u,%zu,%d,%ld,%zu,%zu,%.4f,%.4f,%.4f,%.3f,%.3f,%d,%d,%.5f,%.5f,%.5f,%.6f,%.4f,%.4f,%.5f,%.3f,%.5f,%.5f,"
      "%.5f,"
      "%zu,%zu,%"
      "zu,"
      "%.4f,%.5g,%s\n",
      kind.c_str(), name.c_str(), setting.c_str(), seed, cloud->size(), right ? 1 : 0, static_cast<long>(s.genus),
      s.components, s.interior_vertices, e.candidates_agreeing, e.more_handles, e.fewer_handles, capped(e.gap),
      capped(e.volume_gap), e.guided_agrees ? 1 : 0, e.guide_agrees ? 1 : 0, e.guide_open_edges, e.guide_unused,
      e.guide_shared, e.opposed_triangles, s.sampling->median, s.sampling->high, s.sampling->share_above_one,
      capped(s.topology_margin.value_or(kNone)), share(s.thin_vertices), share(s.buried_vertices), s.sheet_area_share,
      s.joined_parts, s.bodies_seen, s.outliers, s.doubt.value_or(0), s.sum_lambda, warnings.c_str());
  std::fflush(stdout);
}

std::vector<Point3> random_part(const std::vector<Point3>& points, std::size_t part, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Point3> some;
  std::ranges::sample(points, std::back_inserter(some), static_cast<std::ptrdiff_t>(points.size() / part), random);
  return some;
}

/// Random points of the triangles, by area.
class Surface {
 public:
  explicit Surface(surfaced::TriangleMesh mesh) : mesh_(std::move(mesh)) {
    double sum = 0;
    for (const surfaced::Triangle& t : mesh_.triangles) {
      const auto u = surfaced::operator-(mesh_.positions[t[1]], mesh_.positions[t[0]]);
      const auto v = surfaced::operator-(mesh_.positions[t[2]], mesh_.positions[t[0]]);
      sum += surfaced::norm(surfaced::cross(u, v)) / 2;
      sums_.push_back(sum);
    }
  }

  Point3 point(std::mt19937& random) const {
    const double at = random_unit(random) * sums_.back();
    const auto t =
        std::min(static_cast<std::size_t>(std::ranges::upper_bound(sums_, at) - sums_.begin()), sums_.size() - 1);
    double a = random_unit(random);
    double b = random_unit(random);
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    const auto& [i, j, k] = mesh_.triangles[t];
    Point3 p;
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = mesh_.positions[i][c];
      p[c] = x + a * (mesh_.positions[j][c] - x) + b * (mesh_.positions[k][c] - x);
    }
    return p;
  }

  double area() const { return sums_.back(); }
  double volume() const { return surfaced::testing::volume_of(mesh_); }
  const std::vector<Point3>& vertices() const { return mesh_.positions; }

 private:
  surfaced::TriangleMesh mesh_;
  std::vector<double> sums_;
};

/// Random points none of which is nearer than `distance` to another, found in boxes of that size.
std::vector<Point3> spread(const std::function<Point3(std::mt19937&)>& point, double distance, std::size_t darts,
                           std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::pair<std::array<long, 3>, Point3>> kept;
  std::vector<std::vector<Point3>> boxes(4096);
  const auto box_of = [&](const std::array<long, 3>& k) -> std::vector<Point3>& {
    const auto hash = static_cast<unsigned long>(k[0] * 73856093L ^ k[1] * 19349663L ^ k[2] * 83492791L);
    return boxes[hash % boxes.size()];
  };
  std::vector<Point3> points;
  for (std::size_t dart = 0; dart < darts; ++dart) {
    const Point3 p = point(random);
    std::array<long, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = std::lround(std::floor(p[i] / distance));
    bool fits = true;
    for (long x = -1; x <= 1 && fits; ++x) {
      for (long y = -1; y <= 1 && fits; ++y) {
        for (long z = -1; z <= 1 && fits; ++z) {
          for (const Point3& q : box_of({at[0] + x, at[1] + y, at[2] + z})) {
            if (surfaced::norm(surfaced::operator-(p, q)) < distance) fits = false;
          }
        }
      }
    }
    if (!fits) continue;
    box_of(at).push_back(p);
    points.push_back(p);
  }
  return points;
}

struct Wanted {
  std::uint32_t first;
  std::uint32_t last;
  std::string kind;
  std::string name;
  bool has(const std::string& k, const std::string& n) const {
    return (kind == "all" || kind == k) && (name == "all" || name == n);
  }
};

std::string path_of(const std::string& name) { return std::string(SURFACED_SHARED_DATA) + "/" + name + ".ply"; }

void study_clouds(const Wanted& wanted) {
  for (const Model& model : kModels) {
    if (!std::filesystem::exists(path_of(model.name))) continue;
    const auto points = surfaced::make_cloud(*surfaced::read_cloud(path_of(model.name)))->positions;
    if (wanted.has("vertices", model.name)) run_one("vertices", model.name, "1", 0, points, {model.genus});
    if (!wanted.has("part", model.name)) continue;
    for (const std::size_t part : {2U, 3U, 5U, 7U, 10U, 15U, 20U, 30U, 50U, 70U, 100U, 150U, 200U, 300U}) {
      if (points.size() / part < 40 || points.size() / part > 20000) continue;
      for (std::uint32_t seed = wanted.first; seed <= wanted.last; ++seed) {
        run_one("part", model.name, std::to_string(part), seed, random_part(points, part, seed), {model.genus});
      }
    }
  }
}

void study_meshes(const Wanted& wanted) {
  for (const Model& model : kModels) {
    const std::string path = path_of("reference/" + model.name);
    if (!wanted.has("mesh", model.name) || !std::filesystem::exists(path)) continue;
    const Surface surface(*surfaced::read_mesh(path));
    const Truth truth{model.genus, 1, model.name == "bunny" ? 0 : surface.volume()};
    const auto point = [&](std::mt19937& random) { return surface.point(random); };
    for (std::uint32_t seed = wanted.first; seed <= wanted.last; ++seed) {
      for (const std::size_t n : {300U, 700U, 2000U, 5000U}) {
        std::mt19937 random(seed);
        std::vector<Point3> points;
        while (points.size() < n) points.push_back(point(random));
        run_one("mesh", model.name, "random " + std::to_string(n), seed, points, truth);
        const double distance = std::sqrt(surface.area() / static_cast<double>(n) / 0.8);
        run_one("mesh", model.name, "spread " + std::to_string(n), seed, spread(point, distance, 20 * n, seed), truth);
      }
    }
  }
}

void study_bodies(const Wanted& wanted) {
  for (const KnownBody& body : surfaced::testing::known_bodies()) {
    for (std::uint32_t seed = wanted.first; seed <= wanted.last; ++seed) {
      const Truth truth{body.genus, 1, body.volume};
      for (const std::size_t n : {50U, 100U, 200U, 500U, 1500U}) {
        for (const double noise : {0.0, 0.1, 0.25, 0.5}) {
          if (!wanted.has("body", body.name) || (n < 200 && noise > 0)) continue;
          run_one("body", body.name, std::to_string(n) + " " + std::to_string(noise).substr(0, 4), seed,
                  surfaced::testing::points_of(body, n, noise, seed), truth);
        }
        if (!wanted.has("even", body.name)) continue;
        const double distance = std::sqrt(body.area / static_cast<double>(n) / 0.8);
        run_one("even", body.name, std::to_string(n), seed, spread(body.point, distance, 40 * n, seed), truth);
      }
    }
  }
}

void study_several(const Wanted& wanted) {
  const auto bodies = surfaced::testing::known_bodies();
  for (const std::size_t count : {2U, 3U, 5U}) {
    for (const double gap : {1.5, 2.5, 5.0}) {
      for (std::uint32_t seed = wanted.first; seed <= wanted.last; ++seed) {
        if (!wanted.has("several", std::to_string(count))) continue;
        std::mt19937 random(seed);
        std::vector<Point3> points;
        Truth truth{0, count, 0};
        double right_end = 0;
        for (std::size_t k = 0; k < count; ++k) {
          const KnownBody& body = bodies[random() % bodies.size()];
          const std::size_t n = 400 + 200 * (random() % 4);
          std::vector<Point3> own = surfaced::testing::points_of(body, n, 0, static_cast<std::uint32_t>(random()));
          double low = INFINITY;
          double high = -INFINITY;
          for (const Point3& p : own) {
            low = std::min(low, p[0]);
            high = std::max(high, p[0]);
          }
          const double shift = right_end - low + gap * std::sqrt(body.area / static_cast<double>(n));
          for (Point3& p : own) p[0] += shift;
          points.insert(points.end(), own.begin(), own.end());
          right_end = high + shift;
          truth.genus += body.genus;
          truth.volume += body.volume;
        }
        run_one("several", std::to_string(count), std::to_string(gap).substr(0, 3), seed, points, truth);
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> args(argv + 1, argv + argc);
  if (args.size() < 2) {
    std::cerr << "usage: doubt_study FIRST_SEED LAST_SEED [KIND|all [NAME|all]]\n";
    return 2;
  }
  const Wanted wanted{static_cast<std::uint32_t>(std::stoul(args[0])), static_cast<std::uint32_t>(std::stoul(args[1])),
                      args.size() > 2 ? args[2] : "all", args.size() > 3 ? args[3] : "all"};
  print_header();
  study_clouds(wanted);
  study_meshes(wanted);
  study_bodies(wanted);
  study_several(wanted);
  return 0;
}
