// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes for docs/methods/minimum-boundary.md that no parameter of the method gives: Figure 4 of the paper, the
// boundary complex by other criteria than the longest edge; Figure 11, sculpturing from the convex hull and from the
// hull of the boundary complex. Usage: minimum_boundary_figures CLOUD CRITERION|hull-start|bc-start MESH.ply
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <queue>
#include <string>

#include "base/union_find.hpp"
#include "io/io.hpp"
#include "minimum_boundary/hole_covering.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/sculpturing.hpp"

namespace surfaced::boundary {
namespace {

struct Sides {
  double a, b, c;
  double longest() const { return std::max({a, b, c}); }
  double perimeter() const { return a + b + c; }
  double area() const {
    const double s = perimeter() / 2;
    return std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
  }
  double inradius() const { return 2 * area() / perimeter(); }
  double circumradius() const { return a * b * c / (4 * area()); }
  double aspect_ratio() const { return longest() / inradius(); }
};

using Measure = std::function<double(const Sides&)>;

const std::map<std::string, Measure>& measures_by_name() {
  static const std::map<std::string, Measure> measures{
      {"area", [](const Sides& s) { return s.area(); }},
      {"inradius", [](const Sides& s) { return s.inradius(); }},
      {"circumradius", [](const Sides& s) { return s.circumradius(); }},
      {"aspect-ratio", [](const Sides& s) { return s.aspect_ratio(); }},
      {"perimeter", [](const Sides& s) { return s.perimeter(); }},
      {"longest-edge", [](const Sides& s) { return s.longest(); }}};
  return measures;
}

/// Algorithm 1 with any measure, as printed: a queue into which rejected triangles come back.
class Algorithm1 {
 public:
  Algorithm1(const DelaunayComplex& complex, const Measure& measure) : complex_(complex), trees_(complex.points()) {
    for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
      if (s > complex.mate(s) || complex.facet(SideIndex(s))[2] == complex.points()) continue;
      const auto [a, b, c] = complex.facet(SideIndex(s));
      facets_.push_back({measure({length(a, b), length(b, c), length(a, c)}), complex.facet(SideIndex(s))});
    }
    std::ranges::sort(facets_, {}, [](const Facet& f) { return std::pair(f.value, f.vertices); });
    chosen_.assign(facets_.size(), 0);
    for (std::size_t k = 0; k < facets_.size(); ++k) {
      queue_.push(k);
      for (const Edge& e : edges_of(k)) facets_at_[e].push_back(k);
    }
  }

  std::vector<Triangle> run() {
    std::vector<Triangle> triangles;
    while (!queue_.empty() && (open_ > 0 || trees_left_ > 1)) {
      const std::size_t k = queue_.top();
      queue_.pop();
      const auto& [a, b, c] = facets_[k].vertices;
      const bool joins = trees_.find(a) != trees_.find(b) || trees_.find(a) != trees_.find(c);
      const auto edges = edges_of(k);
      const bool closes = std::ranges::any_of(edges, [&](const Edge& e) { return uses_[e] == 1; });
      if (chosen_[k] != 0 || !(joins || closes)) continue;
      chosen_[k] = 1;
      triangles.push_back(facets_[k].vertices);
      for (const VertexIndex v : {b, c}) {
        if (trees_.find(a) == trees_.find(v)) continue;
        trees_.unite(a, v);
        --trees_left_;
      }
      for (const Edge& e : edges) use(e);
    }
    return triangles;
  }

 private:
  using Edge = std::pair<VertexIndex, VertexIndex>;
  struct Facet {
    double value;
    std::array<VertexIndex, 3> vertices;
  };

  double length(VertexIndex a, VertexIndex b) const { return norm(complex_.positions[a] - complex_.positions[b]); }
  std::array<Edge, 3> edges_of(std::size_t k) const {
    const auto& [a, b, c] = facets_[k].vertices;
    return {Edge{a, b}, Edge{b, c}, Edge{a, c}};
  }
  void use(const Edge& e) {
    const int now = ++uses_[e];
    if (now == 2) --open_;
    if (now != 1) return;
    ++open_;
    for (const std::size_t k : facets_at_[e]) {
      if (chosen_[k] == 0) queue_.push(k);
    }
  }

  const DelaunayComplex& complex_;
  std::vector<Facet> facets_;
  std::vector<std::uint8_t> chosen_;
  std::map<Edge, int> uses_;
  std::map<Edge, std::vector<std::size_t>> facets_at_;
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> queue_;
  UnionFind trees_;
  std::size_t trees_left_ = complex_.points();
  std::size_t open_ = 0;
};

/// Sculpturing from the convex hull, or from the covered and inflated hull of the boundary complex.
Result<Labelling> sculptured(const DelaunayComplex& complex, bool from_hull) {
  const Criterion criterion(complex);
  Context context;
  const auto boundary = boundary_complex(complex, criterion, true, context);
  if (!boundary) return boundary.error();
  Labelling labels(complex);
  FacetSet walls = boundary->facets;
  if (from_hull) {
    std::vector<std::uint8_t> finite(complex.cells());
    for (std::size_t c = 0; c < finite.size(); ++c) finite[c] = complex.infinite(CellIndex(c)) ? 0 : 1;
    labels.assign(finite, 1);
  } else {
    const auto covered = cover_by_balls(complex, walls, std::nullopt, context);
    if (!covered) return covered.error();
    walls = covered->facets;
    labels.assign(cells_behind(complex, walls), 1);
    if (const auto inflated = inflate(labels, walls, criterion, context, 1); !inflated) return inflated.error();
  }
  if (const auto done = sculpture(labels, walls, criterion, context); !done) return done.error();
  const Measures m = measure(labels, criterion);
  std::cout << "sum of longest edges " << criterion.length(m.energy) << ", " << m.interior << " points inside, genus "
            << m.handles() << '\n';
  return labels;
}

/// Turns every triangle away from the middle of the points: for the eye only.
void turn_outwards(TriangleMesh& mesh) {
  const Bounds bounds = bounds_of(mesh.positions);
  for (auto& [a, b, c] : mesh.triangles) {
    const Point3& p = mesh.positions[a];
    const Point3 normal = cross(mesh.positions[b] - p, mesh.positions[c] - p);
    Point3 outwards = p;
    for (std::size_t k = 0; k < 3; ++k) outwards[k] -= (bounds.low[k] + bounds.high[k]) / 2;
    if (dot(normal, outwards) < 0) std::swap(b, c);
  }
}

Status run(const std::string& path, const std::string& what, const std::string& out) {
  const Result<RawCloud> raw = read_cloud(path);
  if (!raw) return raw.error();
  const Result<PointCloud> cloud = make_cloud(*raw);
  if (!cloud) return cloud.error();
  Context context;
  const Result<DelaunayComplex> complex = delaunay_complex(*cloud, context, 1);
  if (!complex) return complex.error();
  TriangleMesh mesh;
  mesh.positions = cloud->positions;
  if (const auto found = measures_by_name().find(what); found != measures_by_name().end()) {
    mesh.triangles = Algorithm1(*complex, found->second).run();
    turn_outwards(mesh);
  } else if (what == "hull-start" || what == "bc-start") {
    const Result<Labelling> labels = sculptured(*complex, what == "hull-start");
    if (!labels) return labels.error();
    mesh = surface_of(*labels, *cloud);
  } else {
    return Error{ErrorCode::invalid_parameter, what + " is neither a criterion nor a start"};
  }
  const Result<std::vector<std::byte>> bytes = encode_mesh(mesh, MeshFormat::ply);
  if (!bytes) return bytes.error();
  return write_file(out, *bytes);
}

}  // namespace
}  // namespace surfaced::boundary

int main(int count, char** arguments) {
  if (count != 4) {
    std::cerr << "usage: minimum_boundary_figures CLOUD CRITERION|hull-start|bc-start MESH.ply\n";
    return 2;
  }
  const surfaced::Status status = surfaced::boundary::run(arguments[1], arguments[2], arguments[3]);
  if (!status) std::cerr << status.error().detail << '\n';
  return status ? 0 : 1;
}
