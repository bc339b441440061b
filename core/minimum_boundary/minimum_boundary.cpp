// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/minimum_boundary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <string>

#include "base/parallel.hpp"
#include "minimum_boundary/bodies.hpp"
#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/bridging.hpp"
#include "minimum_boundary/candidates.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/curvature.hpp"
#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/doubt.hpp"
#include "minimum_boundary/evidence.hpp"
#include "minimum_boundary/flatness.hpp"
#include "minimum_boundary/fusing.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/labelling.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/openings.hpp"
#include "minimum_boundary/papers_way.hpp"
#include "minimum_boundary/sampling.hpp"
#include "minimum_boundary/solid_angles.hpp"
#include "minimum_boundary/surgery.hpp"
#include "minimum_boundary/warnings.hpp"
#include "minimum_boundary/watershed.hpp"

namespace surfaced {
namespace boundary {
namespace {

using Parameters = MinimumBoundaryParameters;

/// Guides through the points without repeats, then smoothed once, twice and so on, where all else ends hollow.
constexpr unsigned kSmoothedGuides = 4;
/// Rounds of flips over the edges; the last ones find next to nothing.
constexpr unsigned kStraightenRounds = 8;
/// Diagonals of the quadrilaterals beside a sharp edge differ by less than this; across a thin tube by more.
constexpr double kLongestStretch = 1.8;

/// The facets of the boundary complex themselves, each with the normal of its lesser side.
TriangleMesh mesh_of(const DelaunayComplex& complex, const FacetSet& facets, const PointCloud& cloud) {
  TriangleMesh mesh;
  mesh.positions = cloud.positions;
  mesh.normals = cloud.normals;
  mesh.colors = cloud.colors;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (facets.contains(SideIndex(s)) && s < complex.mate(s)) mesh.triangles.push_back(complex.facet(SideIndex(s)));
  }
  sort_triangles(mesh);
  return mesh;
}

class Run {
 public:
  Run(const PointCloud& cloud, const Parameters& parameters, Context& context)
      : cloud_(cloud), parameters_(parameters), context_(context) {}

  Result<MinimumBoundaryResult> operator()() {
    if (Status body = refuse_flat(cloud_, context_.threads()); !body) return std::move(body).error();
    Result<DelaunayComplex> complex = triangulate();
    if (!complex) return std::move(complex).error();
    const Criterion criterion(*complex);
    result_.statistics.cells = complex->cells();
    look_for_bodies(*complex);
    if (Status begun = context_.begin("boundary-complex", 0.65); !begun) return std::move(begun).error();
    FacetRatings ratings;
    const auto rate = [&](unsigned threads) { ratings = rate_facets(*complex, threads); };
    Result<BoundaryComplex> boundary = wants_watershed()
                                           ? boundary_complex(*complex, criterion, one_body(), context_, rate)
                                           : boundary_complex(*complex, criterion, one_body(), context_);
    if (!boundary) return std::move(boundary).error();
    result_.statistics.boundary_complex_facets = boundary->size;
    result_.statistics.reinserted_facets = boundary->reinserted;
    if (parameters_.stop_after == Parameters::StopAfter::boundary_complex) {
      result_.mesh = mesh_of(*complex, boundary->facets, cloud_);
      return std::move(result_);
    }

    Result<Labelling> labels = make_surface(*complex, *boundary, criterion, std::move(ratings));
    if (!labels) return std::move(labels).error();
    Measures measures = measure(*labels, criterion);
    if (result_.statistics.bodies > 0 && measures.components > result_.statistics.bodies) {
      if (Status joined = join(*labels, *boundary, criterion); !joined) return std::move(joined).error();
      measures = measure(*labels, criterion);
    }
    if (Status begun = context_.begin("surface", 1); !begun) return std::move(begun).error();
    if (wants_straight_diagonals()) {
      const Straightened straightened = straighten(*labels, kLongestStretch, kStraightenRounds, context_.threads());
      result_.statistics.straightened_edges = straightened.flipped;
      result_.statistics.curvature_reduction = straightened.percent();
      measures = measure(*labels, criterion);
    }
    parallel_tasks(context_.threads(), 2, [&](std::size_t task) {
      if (task == 0) {
        summarise(*labels, criterion, measures);
      } else {
        result_.mesh = surface_of(*labels, cloud_);
      }
    });
    if (parameters_.openings == Parameters::Openings::keep)
      result_.statistics.opened_triangles = cut_openings(result_.mesh);
    return std::move(result_);
  }

 private:
  bool wants_watershed() const {
    return parameters_.lids == Parameters::Lids::watershed && parameters_.variant != Parameters::Variant::paper &&
           parameters_.stop_after != Parameters::StopAfter::boundary_complex;
  }

  bool one_body() const { return result_.statistics.bodies == 1; }

  bool wants_guide() const { return wants_watershed() && !wants_one_labelling(); }

  /// The triangulation, and for variant=best the guiding surface: at the same time where there are threads for both,
  /// as inserting points takes but one.
  Result<DelaunayComplex> triangulate() {
    const unsigned threads = context_.threads();
    Status guided = Done{};
    std::optional<Result<DelaunayComplex>> complex;
    const auto make_guide = [&](unsigned own) { guided = add_guide(cloud_.positions, 0, own); };
    if (wants_guide() && threads > 1) {
      parallel_tasks(2, 2, [&](std::size_t task) {
        if (task == 0) {
          complex = delaunay_complex(cloud_, context_, 0.55);
        } else {
          make_guide(threads - 1);
        }
      });
    } else {
      complex = delaunay_complex(cloud_, context_, 0.5);
      if (wants_guide() && *complex) {
        if (Status begun = context_.begin("guide", 0.55); !begun) return std::move(begun).error();
        make_guide(threads);
      }
    }
    if (!*complex) return std::move(*complex);
    if (!guided) return std::move(guided).error();
    return std::move(*complex);
  }

  /// How many bodies the guiding surface shows.
  void look_for_bodies(const DelaunayComplex& complex) {
    MinimumBoundaryStatistics& s = result_.statistics;
    s.bodies = parameters_.components == Parameters::Components::many ? 0 : 1;
    if (!wants_guide()) return;
    // Both were made of the same points, these by a power of two larger or smaller.
    guides_.front().positions = complex.positions;
    s.bodies_seen = count_bodies(complex, guides_.front());
    if (parameters_.components == Parameters::Components::automatic) s.bodies = s.bodies_seen;
  }

  Status add_guide(const std::vector<Point3>& positions, unsigned smoothing_rounds, unsigned threads) {
    Result<GuidingSurface> guide = guiding_surface(positions, smoothing_rounds, context_, threads);
    if (!guide) return std::move(guide).error();
    guides_.push_back(std::move(*guide));
    return Done{};
  }

  bool wants_one_labelling() const {
    return parameters_.variant == Parameters::Variant::fast ||
           parameters_.stop_after == Parameters::StopAfter::inflated;
  }

  bool wants_straight_diagonals() const {
    return parameters_.variant == Parameters::Variant::best &&
           parameters_.diagonals == Parameters::Diagonals::straight &&
           parameters_.stop_after == Parameters::StopAfter::none;
  }

  Result<Labelling> make_surface(const DelaunayComplex& complex, const BoundaryComplex& boundary,
                                 const Criterion& criterion, FacetRatings ratings) {
    const LidCase lid_case{complex, boundary, criterion, parameters_};
    if (parameters_.variant == Parameters::Variant::paper) return papers_way(lid_case, result_.statistics, context_);
    if (parameters_.lids != Parameters::Lids::watershed) {
      const Result<Covered> covered = cover(lid_case, Labelling(complex), result_.statistics, context_);
      if (!covered) return std::move(covered).error();
      return finish(complex, cells_behind(complex, covered->facets), boundary, criterion);
    }
    if (Status begun = context_.begin("watershed", 0.7); !begun) return std::move(begun).error();
    const RatedFacets rated = with_evidence(complex, std::move(ratings), boundary.facets, context_.threads());
    if (wants_one_labelling()) {
      constexpr std::array kLevel{kThoroughLevel};
      const Result<std::vector<Clusters>> clusters =
          guarded_watershed(complex, boundary.facets, rated, kLevel, context_);
      if (!clusters) return clusters.error();
      return finish(complex, inside_of(clusters->front()), boundary, criterion);
    }
    std::vector<Recipe> recipes = recipes_for(complex.points());
    recipes.push_back({Recipe::Kind::guided, 0, 0});
    const std::vector<float> levels = levels_of(recipes);
    const Result<std::vector<Clusters>> clusters = guarded_watershed(complex, boundary.facets, rated, levels, context_);
    if (!clusters) return clusters.error();
    return best({complex, criterion, boundary, rated, recipes, levels, *clusters, guides_});
  }

  /// First labels to a manifold: inflating and descent.
  Result<Labelling> finish(const DelaunayComplex& complex, const std::vector<std::uint8_t>& in,
                           const BoundaryComplex& boundary, const Criterion& criterion) {
    Labelling labels(complex);
    labels.assign(in, context_.threads());
    if (Status begun = context_.begin("inflate", 0.85); !begun) return std::move(begun).error();
    const Result<Inflated> inflated = inflate(labels, boundary.facets, criterion, context_, context_.threads());
    if (!inflated) return inflated.error();
    result_.statistics.inflated_cells = inflated->cells;
    result_.statistics.forced_cells = inflated->forced;
    if (parameters_.stop_after == Parameters::StopAfter::inflated) return labels;
    if (Status done = descend_to_end(labels, criterion); !done) return std::move(done).error();
    return labels;
  }

  Status descend_to_end(Labelling& labels, const Criterion& criterion) {
    if (Status begun = context_.begin("descent", 0.95); !begun) return std::move(begun).error();
    const Result<Descent> descent = descend(labels, criterion, context_, context_.threads());
    if (!descent) return descent.error();
    result_.statistics.exposed_vertices += descent->exposed;
    result_.statistics.flipped_edges += descent->flipped;
    return Done{};
  }

  /// All candidates, the best of them, what is better in the others, and surgery.
  Result<Labelling> best(const Material& material) {
    if (Status begun = context_.begin("candidates", 0.85); !begun) return std::move(begun).error();
    Result<std::vector<Candidate>> candidates = make_candidates_until_sure(material, context_);
    if (!candidates) return std::move(candidates).error();
    const Result<std::size_t> choice = choose(material, *candidates);
    if (!choice) return choice.error();
    const std::size_t chosen = *choice;
    record(*candidates, chosen, material.criterion);
    result_.statistics.evidence = compare_candidates(*candidates, chosen, result_.statistics.bodies);

    if (Status begun = context_.begin("fuse", 0.88); !begun) return std::move(begun).error();
    Labelling labels = candidates->at(chosen).labels;
    SurfaceSearch search(material.complex);
    double margin = std::numeric_limits<double>::infinity();
    Handles handles{candidates->at(chosen).measures.handles(), usual_handles(*candidates)};
    for (std::size_t k = 0; k < candidates->size(); ++k) {
      if (k == chosen) continue;
      const Fused fused = fuse(labels, candidates->at(k).labels, material.criterion, one_body(), handles, search);
      result_.statistics.fused_regions += fused.taken;
      margin = std::min(margin, fused.margin);
    }
    if (Status begun = context_.begin("surgery", 0.92); !begun) return std::move(begun).error();
    if (handles.now > 0) {
      const Result<Surgery> surgery =
          operate(labels, material.criterion, handles, search, context_, context_.threads());
      if (!surgery) return surgery.error();
      result_.statistics.removed_handles = surgery->removed_handles;
      margin = std::min(margin, surgery->margin);
    }
    if (std::isfinite(margin)) result_.statistics.topology_margin = margin;
    if (Status done = descend_to_end(labels, material.criterion); !done) return std::move(done).error();
    return labels;
  }

  /// The best candidate; where that is hollow, after a few more have been added with guides through smoothed points,
  /// each once.
  Result<std::size_t> choose(const Material& material, std::vector<Candidate>& candidates) {
    const std::size_t first = best_of(candidates, result_.statistics.bodies);
    candidates[first].angles = solid_angles(candidates[first].labels, context_.threads());
    if (!hollow(candidates[first])) return first;
    const std::vector<Point3> once = without_repeats(material.complex, context_.threads());
    std::vector<Recipe> recipes;
    for (unsigned rounds = 0; rounds < kSmoothedGuides; ++rounds) {
      recipes.push_back({Recipe::Kind::wound, 0, guides_.size()});
      if (Status made = add_guide(once, rounds, context_.threads()); !made) return std::move(made).error();
    }
    Result<std::vector<Candidate>> more =
        make_candidates({material.complex, material.criterion, material.boundary, material.rated, recipes,
                         material.levels, material.clusters, guides_},
                        context_);
    if (!more) return std::move(more).error();
    for (Candidate& c : *more) candidates.push_back(std::move(c));
    measure_angles(candidates, context_.threads());
    return best_of(candidates, result_.statistics.bodies);
  }

  void record(const std::vector<Candidate>& candidates, std::size_t chosen, const Criterion& criterion) {
    MinimumBoundaryStatistics& s = result_.statistics;
    for (const Candidate& c : candidates) {
      s.candidates.push_back({name_of(c.recipe), c.measures.components, c.measures.handles(), c.measures.interior,
                              criterion.length(c.measures.energy)});
    }
    const Candidate& winner = candidates[chosen];
    s.chosen_candidate = name_of(winner.recipe);
    s.inflated_cells = winner.inflated.cells;
    s.forced_cells = winner.inflated.forced;
    s.exposed_vertices = winner.descent.exposed;
    s.flipped_edges = winner.descent.flipped;
  }

  /// Bridges between what is still apart and shall not be.
  Status join(Labelling& labels, const BoundaryComplex& boundary, const Criterion& criterion) {
    if (Status begun = context_.begin("bridge", 0.97); !begun) return begun;
    const Result<Bridged> bridged =
        bridge(labels, boundary.facets, criterion, result_.statistics.bodies, context_, context_.threads());
    if (!bridged) return bridged.error();
    result_.statistics.bridges = bridged->components_before - bridged->components;
    return Done{};
  }

  void summarise(const Labelling& labels, const Criterion& criterion, const Measures& measures) {
    MinimumBoundaryStatistics& s = result_.statistics;
    s.interior_vertices = measures.interior;
    s.components = measures.components;
    s.genus = measures.handles();
    s.sum_lambda = criterion.length(measures.energy);
    const Sheets sheets = sheets_of(labels);
    s.sheet_area_share = sheets.area_share;
    s.joined_parts = sheets.parts;
    const SolidAngles angles = solid_angles(labels, context_.threads());
    s.thin_vertices = angles.thin;
    s.buried_vertices = angles.buried;
    // In the middle of a wide flat face a point is as far from all others, and no spike.
    s.outliers = static_cast<std::size_t>(
        std::ranges::count_if(sheets.far, [&](VertexIndex v) { return angles.pointed[v] != 0; }));
    if (parameters_.variant != Parameters::Variant::fast) {
      const Sampling sampling = sampling_of(labels, context_.threads());
      s.sampling = MinimumBoundarySampling{sampling.median, sampling.high, sampling.share_above_one};
    }
    if (s.evidence) {
      compare_guide(labels, measures, guides_.front(), *s.evidence);
      s.doubt = doubt_of(s, cloud_.size());
    }
    result_.warnings = warnings_of(s, parameters_, cloud_.size());
    if (parameters_.variant != Parameters::Variant::fast && !s.curvature_reduction) {
      s.curvature_reduction = curvature_reduction(labels, context_.threads());
    }
  }

  const PointCloud& cloud_;
  const Parameters& parameters_;
  Context& context_;
  std::vector<GuidingSurface> guides_;
  MinimumBoundaryResult result_;
};

}  // namespace
}  // namespace boundary

Result<MinimumBoundaryResult> minimum_boundary(const PointCloud& cloud, const MinimumBoundaryParameters& parameters,
                                               Context& context) {
  try {
    return boundary::Run(cloud, parameters, context)();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left for " + std::to_string(cloud.size()) + " points"};
  }
}

}  // namespace surfaced
