// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3, §3.2, with the repairs of docs/DECISIONS.md.
#include "intrinsic_delaunay/upsampling.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/vectors.hpp"
#include "intrinsic_delaunay/proposals.hpp"
#include "mesh/area_normal.hpp"

namespace surfaced::idt {
namespace {

/// No more points than this multiple of the input's.
constexpr std::size_t kMostGrowth = 4;
/// Within one round new points keep this share of their triangle's circumradius from each other: closer ones would
/// serve the same gap. The next round sees what is left.
constexpr double kApart = 0.75;

/// A triangle that is too large, and where its point goes.
struct Gap {
  double circumradius = 0;
  std::size_t triangle = 0;
  Point3 place{};
};

/// The circumcentre, or of an obtuse triangle the middle of the longest edge.
std::optional<Gap> gap_of(const TriangleMesh& mesh, std::size_t index, double epsilon) {
  const Triangle& t = mesh.triangles[index];
  std::size_t apex = 0;  // opposite the longest edge
  std::array<double, 3> squares{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3 edge = mesh.positions[t[(i + 2) % 3]] - mesh.positions[t[(i + 1) % 3]];
    squares[i] = dot(edge, edge);
    if (squares[i] > squares[apex]) apex = i;
  }
  const Point3& a = mesh.positions[t[apex]];
  const Point3 b = mesh.positions[t[(apex + 1) % 3]] - a;
  const Point3 c = mesh.positions[t[(apex + 2) % 3]] - a;
  const Point3 n = cross(b, c);
  const double radius = std::sqrt(squares[0]) * std::sqrt(squares[1]) * std::sqrt(squares[2]) / (2 * norm(n));
  if (!(radius > epsilon)) return std::nullopt;  // degenerate ones have an infinite radius and an obtuse angle
  const Point3 middle = a + 0.5 * (b + c);
  if (!(dot(b, c) > 0) || !std::isfinite(radius)) return Gap{radius, index, middle};
  const Point3 centre = (1 / (2 * dot(n, n))) * cross(dot(b, b) * c - dot(c, c) * b, n);
  return Gap{radius, index, a + centre};
}

std::vector<Gap> gaps_of(const TriangleMesh& mesh, double epsilon) {
  std::vector<Gap> gaps;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (const auto gap = gap_of(mesh, t, epsilon)) gaps.push_back(*gap);
  }
  std::ranges::sort(gaps, [](const Gap& a, const Gap& b) {
    return a.circumradius != b.circumradius ? a.circumradius > b.circumradius : a.triangle < b.triangle;
  });
  return gaps;
}

/// Unit normals of the vertices, zero where no triangle is.
std::vector<Point3> normals_of(const TriangleMesh& mesh) {
  std::vector<Point3> normals = area_normals_at_vertices(mesh.positions, mesh.triangles);
  for (Point3& n : normals) n = direction_of(n).value_or(Point3{});
  return normals;
}

/// New points of a round in cells as wide as the largest distance that is asked for.
class Added {
 public:
  Added(const Bounds& bounds, double cell) : low_(bounds.low), cell_(std::max(cell, kFinest * bounds.diagonal())) {}

  double distance_to_nearest(const Point3& p, double within) const {
    double least = within;
    const auto reach = static_cast<std::int64_t>(std::ceil(within / cell_));
    const auto [x, y, z] = cell_of(p);
    for (std::int64_t i = x - reach; i <= x + reach; ++i) {
      for (std::int64_t j = y - reach; j <= y + reach; ++j) {
        for (std::int64_t k = z - reach; k <= z + reach; ++k) {
          const auto found = cells_.find({i, j, k});
          if (found == cells_.end()) continue;
          for (const Point3& q : found->second) least = std::min(least, norm(q - p));
        }
      }
    }
    return least;
  }
  void add(const Point3& p) { cells_[cell_of(p)].push_back(p); }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Point3& p) const {
    // Circumcentres of thin triangles may be as far away as a double reaches.
    constexpr double kFarthest = 0x1p60;
    Cell cell{};
    for (std::size_t k = 0; k < 3; ++k) {
      cell[k] = static_cast<std::int64_t>(std::clamp(std::floor((p[k] - low_[k]) / cell_), -kFarthest, kFarthest));
    }
    return cell;
  }
  /// Cells finer than this share of the diagonal would not fit their numbers.
  static constexpr double kFinest = 1e-12;
  Point3 low_;
  double cell_;
  std::map<Cell, std::vector<Point3>> cells_;
};

class Run {
 public:
  Run(PointCloud cloud, TriangleMesh mesh, double epsilon, Upsampling way, Context& context)
      : way_(way), context_(context), most_points_(kMostGrowth * cloud.size()) {
    result_.cloud = std::move(cloud);
    result_.mesh = std::move(mesh);
    result_.statistics.epsilon = epsilon;
  }

  Result<Upsampled> operator()(const Reconstruct& reconstruct) {
    UpsamplingStatistics& s = result_.statistics;
    while (true) {
      context_.enter("upsampling", 1);
      const std::vector<Gap> gaps = gaps_of(result_.mesh, s.epsilon);
      s.large_triangles = gaps.size();
      if (gaps.empty() || result_.cloud.size() >= most_points_) break;
      const std::size_t before = result_.cloud.size();
      if (Status grown = add_points(gaps); !grown) return std::move(grown).error();
      if (result_.cloud.size() == before) break;
      ++s.rounds;
      s.points_added += result_.cloud.size() - before;
      Result<TriangleMesh> mesh = reconstruct(result_.cloud);
      if (!mesh) return std::move(mesh).error();
      result_.mesh = std::move(*mesh);
    }
    return std::move(result_);
  }

 private:
  Status add_points(const std::vector<Gap>& gaps) {
    const double epsilon = result_.statistics.epsilon;
    const std::vector<Point3> normals = normals_of(result_.mesh);
    Surroundings surroundings(result_.cloud.positions, normals, epsilon);
    if (way_ == Upsampling::paper) surroundings.describe_patches(context_);
    Added added(bounds_of(result_.cloud.positions), epsilon);
    RawCloud raw{result_.cloud.positions, result_.cloud.normals, result_.cloud.colors, {}};
    for (const Gap& gap : gaps) {
      if (context_.cancelled()) return Error{ErrorCode::cancelled, "cancelled while upsampling"};
      if (raw.size() >= most_points_) break;
      const double apart = std::min(kApart * gap.circumradius, 4 * epsilon);
      const auto fits = [&](const Point3& p) {
        return is_finite(p) && norm(p - gap.place) <= epsilon && surroundings.distance_to_nearest(p) >= epsilon / 2 &&
               added.distance_to_nearest(p, std::max(apart, epsilon)) >= std::max(apart, epsilon / 2);
      };
      const std::optional<Point3> point = point_for(gap, surroundings, fits);
      if (!point) continue;
      added.add(*point);
      append(raw, *point, result_.mesh.triangles[gap.triangle]);
    }
    Result<PointCloud> cloud = make_cloud(std::move(raw));
    if (!cloud) return std::move(cloud).error();
    result_.cloud = std::move(*cloud);
    return Done{};
  }

  template <class Fits>
  std::optional<Point3> point_for(const Gap& gap, const Surroundings& surroundings, const Fits& fits) {
    if (way_ == Upsampling::paper) {
      const auto refined = surroundings.from_similar_patch(surroundings.gaussian_mean(gap.place));
      if (refined && fits(*refined)) {
        ++result_.statistics.from_patches;
        return refined;
      }
    }
    const auto shape = surroundings.shape_at(gap.place);
    if (!shape) return std::nullopt;
    const Point3 on_jet = shape->above(gap.place);
    return fits(on_jet) ? std::optional(on_jet) : std::nullopt;
  }

  /// A point with the mean attributes of its triangle.
  static void append(RawCloud& raw, const Point3& p, const Triangle& t) {
    raw.positions.push_back(p);
    if (!raw.normals.empty()) {
      Point3 sum{};
      for (const VertexIndex v : t) {
        const Normal3& n = raw.normals[v];
        sum += Point3{n[0], n[1], n[2]};
      }
      const Point3 n = direction_of(sum).value_or(Point3{0, 0, 1});
      raw.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
    }
    if (raw.colors.empty()) return;
    Color4 mean{};
    for (std::size_t k = 0; k < 4; ++k) {
      unsigned sum = 1;  // rounds
      for (const VertexIndex v : t) sum += raw.colors[v][k];
      mean[k] = static_cast<std::uint8_t>(sum / 3);
    }
    raw.colors.push_back(mean);
  }

  Upsampling way_;
  Context& context_;
  std::size_t most_points_;
  Upsampled result_;
};

}  // namespace

std::size_t large_triangles(const TriangleMesh& mesh, double epsilon) { return gaps_of(mesh, epsilon).size(); }

Result<Upsampled> upsample(PointCloud cloud, TriangleMesh mesh, double epsilon, Upsampling way,
                           const Reconstruct& reconstruct, Context& context) {
  return Run(std::move(cloud), std::move(mesh), epsilon, way, context)(reconstruct);
}

double automatic_epsilon(const PointCloud& cloud, Context& context) {
  constexpr std::size_t kSixth = 6;
  if (cloud.size() <= kSixth) return bounds_of(cloud.positions).diagonal();
  const PointTree tree(cloud.positions);
  std::vector<double> distances(cloud.size());
  const auto measure = [&](std::size_t i) {
    const Point3& p = cloud.positions[i];
    distances[i] = norm(cloud.positions[tree.nearest(p, kSixth + 1).back()] - p);
  };
  for (std::size_t i = 0; i < cloud.size() && !context.cancelled(); ++i) measure(i);
  const std::size_t at = distances.size() * 95 / 100;
  std::ranges::nth_element(distances, distances.begin() + static_cast<std::ptrdiff_t>(at));
  return distances[at];
}

}  // namespace surfaced::idt
