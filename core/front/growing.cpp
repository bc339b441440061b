// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/growing.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "front/consensus.hpp"

namespace surfaced::front {
namespace {

constexpr std::size_t kFewestPoints = 3;
/// Longest rim that counts as a small hole, in edges.
constexpr std::size_t kSmallHole = 30;
/// Largest set of connected rim vertices that repair takes on.
constexpr std::size_t kSmallDamage = 60;
/// So few points are a whole body more often than a piece of a surface: normals taken across them mean little.
constexpr std::size_t kHandful = 12;
/// Least cosine between faces at the holes closed: 120 degrees; 154 for the corners of a handful.
constexpr double kClosingCosine = -0.5;
constexpr double kHandfulCosine = -0.9;

/// Which way normals are taken.
enum class Normals : std::uint8_t { across_neighbours, away_from_centre };

class Run {
 public:
  Run(const PointCloud& cloud, const GrowthParameters& parameters, Context& context,
      Normals normals = Normals::across_neighbours)
      : cloud_(cloud), parameters_(parameters), context_(context), normals_(normals) {}

  Result<Surface> operator()() {
    if (Status made = triangulate(); !made) return std::move(made).error();
    context_.enter("surface", 1);
    TriangleMesh& mesh = result_.mesh;
    mesh.positions = cloud_.positions;
    mesh.normals = cloud_.normals;
    mesh.colors = cloud_.colors;
    orient_oriented_outwards(mesh);
    sort_triangles(mesh);
    return std::move(result_);
  }

 private:
  /// All that needs the neighbourhoods; they are gone when the mesh takes its room.
  Status triangulate() {
    if (Status begun = context_.begin("neighbourhoods", 0.7); !begun) return begun;
    const BoxTree tree(cloud_.positions, context_.threads());
    StarParameters star_parameters = parameters_.stars;
    star_parameters.spacings = parameters_.sewing.max_edge || parameters_.sewing.capsule;
    Result<LocalStars> stars = local_stars(tree, star_parameters, context_);
    if (!stars) return std::move(stars).error();

    if (Status begun = context_.begin("consensus", 0.8); !begun) return begun;
    FaceMasks faces = agreed_faces(*stars, context_.threads());
    result_.statistics.one_sided_faces = orient(*stars, faces);
    if (normals_ == Normals::away_from_centre) turn_away(tree, *stars);
    if (!parameters_.begin_with_consensus || normals_ == Normals::away_from_centre) std::ranges::fill(faces, 0U);
    Fans fans(*stars, std::move(faces));
    result_.statistics.agreed_faces = fans.faces();
    Places places(tree, *stars, parameters_.sewing);
    drop_forbidden_faces(fans, places);

    if (Status begun = context_.begin("front", 0.9); !begun) return begun;
    if (Status advanced = sew(fans, places); !advanced) return advanced;
    if (Status filled = finish(fans, places); !filled) return filled;
    if (parameters_.improve) {
      if (Status improved = parameters_.improve(fans, places, context_); !improved) return improved;
    }
    note_rim(fans);
    result_.mesh.triangles = fans.triangles();
    return Done{};
  }

  static void turn_away(const BoxTree& tree, LocalStars& stars) {
    Point3 centre{};
    for (std::size_t v = 0; v < tree.points(); ++v) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        centre[axis] += tree.local(v)[axis] / static_cast<double>(tree.points());
      }
    }
    for (std::size_t v = 0; v < tree.points(); ++v) {
      const Point3 out = tree.local(v) - centre;
      const double length = norm(out);
      if (!(length > 0)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) stars.normals[v][axis] = static_cast<float>(out[axis] / length);
    }
  }

  void drop_forbidden_faces(Fans& fans, Places& places) const {
    if (!parameters_.limit_consensus || (!parameters_.sewing.max_edge && !parameters_.sewing.capsule)) return;
    for (const Triangle& t : fans.triangles()) {
      const Face f{t[0].value, t[1].value, t[2].value};
      if (!places.allows(f)) fans.remove(f);
    }
  }

  /// The front from what there is, then from new seeds, then less strictly.
  Status sew(Fans& fans, Places& places) {
    constexpr Pass kStrict{0.5, false};
    Front front(fans, places);
    for (const Pass& pass : {Pass{0.5, false, Pass::Among::stars}, kStrict}) {
      if (Status advanced = advance(front, pass, fans.unsettled()); !advanced) return advanced;
    }
    for (const std::uint32_t v : fans.unsettled()) {
      if (fans.around(v) != Around::nothing || !parameters_.plant(fans, places, v)) continue;
      ++result_.statistics.seeds;
      if (Status advanced = advance(front, kStrict, seeded_at(fans, places, v)); !advanced) return advanced;
    }
    std::vector<Pass> passes{{0, false}, {0, true}};
    // Where everybody is everybody's neighbour there is no rim to fold over: corners of a cube, a tetrahedron.
    if (fans.points() <= parameters_.sewing.reach) passes.push_back({-0.5, true});
    for (const Pass& pass : passes) {
      if (Status advanced = advance(front, pass, fans.unsettled()); !advanced) return advanced;
    }
    return Done{};
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

  Status advance(Front& front, const Pass& pass, const std::vector<std::uint32_t>& from) {
    const Result<std::size_t> added = front.advance(pass, from, context_);
    if (!added) return added.error();
    result_.statistics.sewn_faces += *added;
    return Done{};
  }

  Status finish(Fans& fans, Places& places) {
    Statistics& s = result_.statistics;
    if (parameters_.fill_small_holes) {
      if (Status begun = context_.begin("holes", 0.95); !begun) return begun;
      const double least_cosine = fans.points() <= kHandful ? kHandfulCosine : kClosingCosine;
      s.holes_closed = close_holes(fans, places, fans.unsettled(), {kSmallHole, least_cosine});
      const Result<std::size_t> repaired = repair_holes(fans, places, kSmallDamage, context_);
      if (!repaired) return repaired.error();
      s.holes_repaired = *repaired;
    }
    s.separated_faces = separate_fans(fans);
    s.points_inserted = insert_leftovers(fans, places);
    return Done{};
  }

  void note_rim(const Fans& fans) {
    std::vector<Edge> open;
    for (const std::uint32_t v : fans.unsettled()) {
      open.clear();
      open_edges(fans, v, open);
      result_.statistics.open_edges += open.size();
    }
    result_.statistics.open_edges /= 2;  // seen from both ends
  }

  const PointCloud& cloud_;
  const GrowthParameters& parameters_;
  Context& context_;
  Normals normals_;
  Surface result_;
};

std::size_t used_points(const Surface& surface) {
  std::vector<bool> used(surface.mesh.positions.size(), false);
  for (const Triangle& t : surface.mesh.triangles) {
    for (const VertexIndex v : t) used[v] = true;
  }
  return static_cast<std::size_t>(std::ranges::count(used, true));
}

/// A handful of points once more with normals that point away from their centre, if that gives a closed surface
/// through all of them and the usual way did not.
Result<Surface> grow_handful(const PointCloud& cloud, const GrowthParameters& parameters, Context& context) {
  Result<Surface> usual = Run(cloud, parameters, context)();
  const auto complete = [&](const Result<Surface>& s) {
    return s && s->statistics.open_edges == 0 && used_points(*s) == cloud.size();
  };
  if (!usual || complete(usual)) return usual;
  Result<Surface> other = Run(cloud, parameters, context, Normals::away_from_centre)();
  return complete(other) ? std::move(other) : std::move(usual);
}

}  // namespace

Result<Surface> grow_surface(const PointCloud& cloud, const GrowthParameters& parameters, Context& context) {
  const std::string points = std::to_string(cloud.size()) + " distinct points";
  if (cloud.size() < kFewestPoints) {
    return Error{ErrorCode::too_few_points, points + " of " + std::to_string(cloud.input_to_vertex.size()) +
                                                " remain; " + std::string(parameters.method) + " needs " +
                                                std::to_string(kFewestPoints)};
  }
  if (all_on_a_line(cloud.positions)) return Error{ErrorCode::collinear, "all " + points + " lie on one line"};
  try {
    if (cloud.size() <= kHandful) return grow_handful(cloud, parameters, context);
    return Run(cloud, parameters, context)();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left for " + points};
  }
}

}  // namespace surfaced::front
