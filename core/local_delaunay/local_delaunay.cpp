// Source: H. H. Bíscaro, "Efficient reconstruction from scattered points", WSCG 2010.
#include "local_delaunay/local_delaunay.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "front/front.hpp"
#include "local_delaunay/seeding.hpp"

namespace surfaced {
namespace ldt {
namespace {

using Parameters = LocalDelaunayParameters;
using front::Around;
using front::FaceMasks;
using front::Fans;
using front::LocalStars;
using front::Pass;
using front::Places;

constexpr std::size_t kFewestPoints = 3;
/// Longest rim that counts as a small hole, in edges.
constexpr std::size_t kSmallHole = 30;
/// Largest set of connected rim vertices that repair takes on.
constexpr std::size_t kSmallDamage = 60;

front::StarParameters star_parameters(const Parameters& p) {
  front::StarParameters s;
  s.neighbours = p.neighbours;
  if (p.star == Parameters::Star::unfolded) s.kind = front::StarKind::unfolded;
  if (p.star == Parameters::Star::projected) s.kind = front::StarKind::projected;
  return s;
}

front::SewingParameters sewing_parameters(const Parameters& p) {
  front::SewingParameters s;
  s.angle = p.angle == Parameters::Angle::projected ? front::Angle::projected : front::Angle::spatial;
  s.reach = std::max(s.reach, 2 * p.neighbours);
  s.max_edge = p.max_edge;
  return s;
}

class Run {
 public:
  Run(const PointCloud& cloud, const Parameters& parameters, Context& context)
      : cloud_(cloud), parameters_(parameters), context_(context) {}

  Result<LocalDelaunayResult> operator()() {
    if (Status made = triangulate(); !made) return std::move(made).error();
    context_.enter("surface", 1);
    TriangleMesh& mesh = result_.mesh;
    mesh.positions = cloud_.positions;
    mesh.normals = cloud_.normals;
    mesh.colors = cloud_.colors;
    orient_manifold_outwards(mesh, rim_);
    sort_triangles(mesh);
    if (result_.statistics.open_edges > 0) {
      result_.warnings.push_back("the mesh is open: " + std::to_string(result_.statistics.open_edges) +
                                 " edges have one triangle");
    }
    return std::move(result_);
  }

 private:
  /// Enters a stage unless the caller wants to stop.
  Status begin(std::string_view stage, double until) {
    context_.enter(stage, until);
    if (context_.cancelled()) return Error{ErrorCode::cancelled, "cancelled at stage " + std::string(stage)};
    return Done{};
  }

  /// All that needs the neighbourhoods; they are gone when the mesh takes its room.
  Status triangulate() {
    if (Status begun = begin("neighbourhoods", 0.7); !begun) return begun;
    const BoxTree tree(cloud_.positions, context_.threads());
    Result<LocalStars> stars = front::local_stars(tree, star_parameters(parameters_), context_);
    if (!stars) return std::move(stars).error();

    if (Status begun = begin("consensus", 0.8); !begun) return begun;
    FaceMasks faces = front::agreed_faces(*stars, context_.threads());
    result_.statistics.one_sided_faces = front::orient(*stars, faces);
    if (parameters_.seed == Parameters::Seed::paper) std::ranges::fill(faces, 0U);
    Fans fans(*stars, std::move(faces));
    result_.statistics.agreed_faces = fans.faces();
    Places places(tree, *stars, sewing_parameters(parameters_));
    drop_long_faces(fans, places);

    if (Status begun = begin("front", 0.9); !begun) return begun;
    if (Status advanced = sew(fans, places); !advanced) return advanced;
    if (Status filled = finish(fans, places); !filled) return filled;
    result_.mesh.triangles = fans.triangles();
    return Done{};
  }

  void drop_long_faces(Fans& fans, Places& places) const {
    if (!parameters_.max_edge) return;
    for (const Triangle& t : fans.triangles()) {
      const front::Face f{t[0].value, t[1].value, t[2].value};
      const bool all_short =
          places.short_enough(f[0], f[1]) && places.short_enough(f[1], f[2]) && places.short_enough(f[2], f[0]);
      if (!all_short) fans.remove(f);
    }
  }

  /// Paper 2, algorithm 1, steps 4 to 13: the front from what there is, then from new seeds, then less strictly.
  Status sew(Fans& fans, Places& places) {
    constexpr Pass kStrict{0.5, false};
    front::Front front(fans, places);
    for (const Pass& pass : {Pass{0.5, false, Pass::Among::stars}, kStrict}) {
      if (Status advanced = advance(front, pass, fans.unsettled()); !advanced) return advanced;
    }
    for (const std::uint32_t v : fans.unsettled()) {
      if (fans.around(v) != Around::nothing || !plant(fans, places, v)) continue;
      ++result_.statistics.seeds;
      if (Status advanced = advance(front, kStrict, seeded_at(fans, places, v)); !advanced) return advanced;
    }
    std::vector<Pass> passes{{0, false}, {0, true}};
    // Where everybody is everybody's neighbour there is no rim to fold over: corners of a cube, a tetrahedron.
    if (fans.points() <= sewing_parameters(parameters_).reach) passes.push_back({-0.5, true});
    for (const Pass& pass : passes) {
      if (Status advanced = advance(front, pass, fans.unsettled()); !advanced) return advanced;
    }
    return Done{};
  }

  bool plant(Fans& fans, Places& places, std::uint32_t v) const {
    if (parameters_.seed == Parameters::Seed::triangle) return seed_triangle(fans, places, v);
    return seed_local_triangulation(fans, places, v, parameters_.neighbours);
  }

  /// The vertices of the seed at v, ascending.
  static std::vector<std::uint32_t> seeded_at(const Fans& fans, Places& places, std::uint32_t v) {
    std::vector<std::uint32_t> vertices{v};
    for (const std::uint32_t u : places.neighbours(v)) {
      if (fans.around(u) != Around::nothing) vertices.push_back(u);
    }
    std::ranges::sort(vertices);
    return vertices;
  }

  Status advance(front::Front& front, const Pass& pass, const std::vector<std::uint32_t>& from) {
    const Result<std::size_t> added = front.advance(pass, from, context_);
    if (!added) return added.error();
    result_.statistics.sewn_faces += *added;
    return Done{};
  }

  Status finish(Fans& fans, Places& places) {
    LocalDelaunayStatistics& s = result_.statistics;
    if (parameters_.fill_holes == Parameters::FillHoles::small) {
      if (Status begun = begin("holes", 0.95); !begun) return begun;
      constexpr double kLeastCosine = -0.5;
      s.holes_closed = front::close_holes(fans, places, fans.unsettled(), {kSmallHole, kLeastCosine});
      const Result<std::size_t> repaired = front::repair_holes(fans, places, kSmallDamage, context_);
      if (!repaired) return repaired.error();
      s.holes_repaired = *repaired;
    }
    s.separated_faces = front::separate_fans(fans);
    s.points_inserted = front::insert_leftovers(fans, places);
    std::vector<front::Edge> open;
    for (const std::uint32_t v : fans.unsettled()) {
      open.clear();
      front::open_edges(fans, v, open);
      if (!open.empty()) rim_.emplace_back(v);
      s.open_edges += open.size();
    }
    s.open_edges /= 2;  // seen from both ends
    return Done{};
  }

  const PointCloud& cloud_;
  const Parameters& parameters_;
  Context& context_;
  LocalDelaunayResult result_;
  std::vector<VertexIndex> rim_;
};

}  // namespace
}  // namespace ldt

Result<LocalDelaunayResult> local_delaunay(const PointCloud& cloud, const LocalDelaunayParameters& parameters,
                                           Context& context) {
  const std::string points = std::to_string(cloud.size()) + " distinct points";
  if (cloud.size() < ldt::kFewestPoints) {
    return Error{ErrorCode::too_few_points,
                 points + " of " + std::to_string(cloud.input_to_vertex.size()) + " remain; local-delaunay needs 3"};
  }
  if (ldt::all_on_a_line(cloud.positions)) {
    return Error{ErrorCode::collinear, "all " + points + " lie on one line"};
  }
  try {
    return ldt::Run(cloud, parameters, context)();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left for " + points};
  }
}

}  // namespace surfaced
