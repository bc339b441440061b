// SPDX-License-Identifier: GPL-3.0-or-later
// Not timed by a framework: what our dynamic programme and CGAL's hole filling make of the rims that the front of
// local-delaunay leaves on clouds (docs/DECISIONS.md).
//   build/release/hole_filling_peers CLOUD...
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <span>

#include "front/front.hpp"
#include "hole_filling/hole_filling.hpp"
#include "io/io.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Clock = std::chrono::steady_clock;

constexpr double kLeastCosine = -0.5;
constexpr std::size_t kLongest = 30;

Triangles by_cgal(const Loop& loop, bool delaunay) {
  const auto exact = [](const std::vector<Point3>& points) {
    std::vector<Kernel::Point_3> result;
    for (const Point3& p : points) result.emplace_back(p[0], p[1], p[2]);
    return result;
  };
  std::vector<CGAL::Triple<int, int, int>> patch;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(exact(loop.corners), exact(loop.beyond),
                                                           std::back_inserter(patch),
                                                           CGAL::parameters::use_delaunay_triangulation(delaunay));
  Triangles result;
  for (const auto& t : patch) {
    result.push_back({static_cast<std::uint32_t>(t.first), static_cast<std::uint32_t>(t.second),
                      static_cast<std::uint32_t>(t.third)});
  }
  return result;
}

struct Tally {
  std::size_t closed = 0;
  std::size_t none = 0;
  std::size_t joined = 0;
  std::size_t bent = 0;
  double area = 0;
  double seconds = 0;
};

/// One loop, the pairs that must not be joined, and the judge of a triangulation.
struct Case {
  Loop loop;
  std::function<bool(std::size_t, std::size_t)> may_join;

  double area(const Triangles& patch) const {
    double sum = 0;
    for (const auto& t : patch) sum += norm(normal(t)) / 2;
    return sum;
  }
  Point3 normal(const std::array<std::uint32_t, 3>& t) const {
    const Point3& a = loop.corners[t[0]];
    return cross(loop.corners[t[1]] - a, loop.corners[t[2]] - a);
  }
  bool joins_forbidden(const Triangles& patch) const {
    const std::size_t n = loop.corners.size();
    return std::ranges::any_of(patch, [&](const auto& t) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t a = t[i];
        const std::size_t b = t[(i + 1) % 3];
        if ((a + 1) % n != b && (b + 1) % n != a && !may_join(a, b)) return true;
      }
      return false;
    });
  }
  double least_cosine(const Triangles& patch) const {
    const std::size_t n = loop.corners.size();
    double least = 1;
    const auto meet = [&](const Point3& a, const Point3& b) { least = std::min(least, front::cosine(a, b)); };
    for (std::size_t s = 0; s < patch.size(); ++s) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = patch[s][i];
        const std::uint32_t b = patch[s][(i + 1) % 3];
        if ((a + 1) % n == b) {
          const Point3& from = loop.corners[b];
          meet(normal(patch[s]), cross(loop.corners[a] - from, loop.beyond[a] - from));
        }
        for (std::size_t t = s + 1; t < patch.size(); ++t) {
          for (std::size_t j = 0; j < 3; ++j) {
            if (patch[t][j] == b && patch[t][(j + 1) % 3] == a) meet(normal(patch[s]), normal(patch[t]));
          }
        }
      }
    }
    return least;
  }
};

template <class Fill>
Triangles timed(Tally& tally, Fill&& fill) {
  const auto begin = Clock::now();
  Triangles patch = fill();
  tally.seconds += std::chrono::duration<double>(Clock::now() - begin).count();
  return patch;
}

void judge(const Case& c, const Triangles& patch, Tally& tally) {
  if (patch.empty()) {
    ++tally.none;
  } else if (c.joins_forbidden(patch)) {
    ++tally.joined;
  } else if (c.least_cosine(patch) < kLeastCosine) {
    ++tally.bent;
  } else {
    ++tally.closed;
    tally.area += c.area(patch);
  }
}

std::vector<Case> cases_of(const PointCloud& cloud) {
  Context context;
  const BoxTree tree(cloud.positions, 1);
  front::LocalStars stars = *front::local_stars(tree, {}, context);
  front::FaceMasks faces = front::agreed_faces(stars, 1);
  front::orient(stars, faces);
  front::Fans fans(stars, std::move(faces));
  front::Places places(tree, stars, {});
  front::Front front(fans, places);
  for (const front::Pass& pass : {front::Pass{0.5, false, front::Pass::Among::stars}, front::Pass{0.5, false},
                                  front::Pass{0, false}, front::Pass{0, true}}) {
    (void)front.advance(pass, context);
  }
  std::vector<Case> cases;
  for (const front::Rim& rim : front::rims_at(fans, places, fans.unsettled(), kLongest)) {
    Case c;
    std::vector<bool> joined(rim.size() * rim.size());
    for (std::size_t i = 0; i < rim.size(); ++i) {
      c.loop.corners.push_back(places.position(rim[i]));
      c.loop.beyond.push_back(places.position(fans.apex({rim[i + 1 < rim.size() ? i + 1 : 0], rim[i]})));
      for (std::size_t j = 0; j < rim.size(); ++j)
        joined[i * rim.size() + j] = fans.uses({rim[i], rim[j]}) || fans.uses({rim[j], rim[i]});
    }
    c.may_join = [joined, n = rim.size()](std::size_t i, std::size_t j) { return !joined[i * n + j]; };
    cases.push_back(std::move(c));
  }
  return cases;
}

void print(const char* who, const Tally& t, std::size_t loops) {
  std::printf("  %-22s closed %4zu  none %3zu  joins an edge %3zu  too bent %3zu  area %.6g  %.1f us a loop\n", who,
              t.closed, t.none, t.joined, t.bent, t.area,
              1e6 * t.seconds / static_cast<double>(std::max<std::size_t>(loops, 1)));
}

int run(std::span<char*> files) {
  for (const char* file : files) {
    auto raw = read_cloud(file);
    if (!raw) {
      std::fprintf(stderr, "%s\n", raw.error().detail.c_str());
      return 1;
    }
    const std::vector<Case> cases = cases_of(*make_cloud(std::move(*raw)));
    Tally ours;
    Tally plain;
    Tally delaunay;
    std::size_t edges = 0;
    for (const Case& c : cases) {
      edges += c.loop.corners.size();
      const LoopLimits limits{kLeastCosine, c.may_join};
      judge(c, timed(ours, [&] { return triangulate_loop(c.loop, limits).value_or(Triangles{}); }), ours);
      judge(c, timed(plain, [&] { return by_cgal(c.loop, false); }), plain);
      judge(c, timed(delaunay, [&] { return by_cgal(c.loop, true); }), delaunay);
    }
    std::printf("%s: %zu rims, %zu edges\n", std::filesystem::path(file).stem().c_str(), cases.size(), edges);
    print("ours", ours, cases.size());
    print("CGAL", plain, cases.size());
    print("CGAL, Delaunay first", delaunay, cases.size());
  }
  return 0;
}

}  // namespace
}  // namespace surfaced

int main(int argc, char** argv) { return surfaced::run(std::span(argv, static_cast<std::size_t>(argc)).subspan(1)); }
