#include "minimum_boundary/minimum_boundary.hpp"

#include <new>

#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/candidates.hpp"
#include "minimum_boundary/criterion.hpp"

#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/fusing.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/labelling.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/surgery.hpp"
#include "minimum_boundary/watershed.hpp"

namespace surfaced {
namespace boundary {
namespace {

using Parameters = MinimumBoundaryParameters;

/// The facets of the boundary complex themselves, each with the normal of its lesser side.
TriangleMesh mesh_of(const DelaunayComplex& complex, const FacetSet& facets, const PointCloud& cloud) {
  TriangleMesh mesh;
  mesh.positions = cloud.positions;
  mesh.normals = cloud.normals;
  mesh.colors = cloud.colors;
  for (std::size_t s = 0; s < complex.mates.size(); ++s) {
    if (facets.contains(SideIndex(s)) && s < complex.mates[s]) mesh.triangles.push_back(complex.facet(SideIndex(s)));
  }
  sort_triangles(mesh);
  return mesh;
}

class Run {
 public:
  Run(const PointCloud& cloud, const Parameters& parameters, Context& context)
      : cloud_(cloud), parameters_(parameters), context_(context) {}

  Result<MinimumBoundaryResult> operator()() {
    Result<DelaunayComplex> complex = delaunay_complex(cloud_, context_, 0.5);
    if (!complex) return std::move(complex).error();
    const Criterion criterion(*complex);
    result_.statistics.cells = complex->cells();

    if (Status begun = begin("boundary-complex", 0.65); !begun) return std::move(begun).error();
    const bool connected = parameters_.components == Parameters::Components::one;
    Result<BoundaryComplex> boundary = boundary_complex(*complex, criterion, connected, context_);
    if (!boundary) return std::move(boundary).error();
    result_.statistics.boundary_complex_facets = boundary->size;
    result_.statistics.reinserted_facets = boundary->reinserted;
    if (parameters_.stop_after == Parameters::StopAfter::boundary_complex) {
      result_.mesh = mesh_of(*complex, boundary->facets, cloud_);
      return std::move(result_);
    }

    Result<Labelling> labels = make_surface(*complex, *boundary, criterion);
    if (!labels) return std::move(labels).error();
    if (Status begun = begin("surface", 1); !begun) return std::move(begun).error();
    summarise(*labels, criterion);
    result_.mesh = surface_of(*labels, cloud_);
    return std::move(result_);
  }

 private:
  /// Enters a stage unless the caller wants to stop.
  Status begin(std::string_view stage, double until) {
    context_.enter(stage, until);
    if (context_.cancelled()) return Error{ErrorCode::cancelled, "cancelled at stage " + std::string(stage)};
    return Done{};
  }

  Result<Labelling> make_surface(const DelaunayComplex& complex, const BoundaryComplex& boundary,
                                 const Criterion& criterion) {
    if (parameters_.lids == Parameters::Lids::none) {
      return finish(complex, cells_behind(complex, boundary.facets), boundary, criterion);
    }
    if (Status begun = begin("watershed", 0.7); !begun) return std::move(begun).error();
    const RatedFacets rated = rate_facets(complex, boundary.facets, context_.threads());
    const bool fast =
        parameters_.variant == Parameters::Variant::fast || parameters_.stop_after == Parameters::StopAfter::inflated;
    const std::vector<float> levels =
        fast ? std::vector{kThoroughLevel} : std::vector{kCautiousLevel, kColouringLevel, kThoroughLevel};
    const Result<std::vector<Clusters>> clusters = guarded_watershed(complex, boundary.facets, rated, levels, context_);
    if (!clusters) return clusters.error();
    if (fast) return finish(complex, inside_of(clusters->back()), boundary, criterion);
    return best({complex, criterion, boundary, rated, clusters->at(2), clusters->at(1), clusters->at(0)});
  }

  /// First labels to a manifold: inflating and descent.
  Result<Labelling> finish(const DelaunayComplex& complex, const std::vector<std::uint8_t>& in,
                           const BoundaryComplex& boundary, const Criterion& criterion) {
    Labelling labels(complex);
    labels.assign(in, context_.threads());
    if (Status begun = begin("inflate", 0.85); !begun) return std::move(begun).error();
    const Result<Inflated> inflated = inflate(labels, boundary.facets, criterion, context_, context_.threads());
    if (!inflated) return inflated.error();
    result_.statistics.inflated_cells = inflated->cells;
    result_.statistics.forced_cells = inflated->forced;
    if (parameters_.stop_after == Parameters::StopAfter::inflated) return labels;
    if (Status done = descend_to_end(labels, criterion); !done) return std::move(done).error();
    return labels;
  }

  Status descend_to_end(Labelling& labels, const Criterion& criterion) {
    if (Status begun = begin("descent", 0.95); !begun) return std::move(begun).error();
    const Result<Descent> descent = descend(labels, criterion, context_, context_.threads());
    if (!descent) return descent.error();
    result_.statistics.exposed_vertices += descent->exposed;
    result_.statistics.flipped_edges += descent->flipped;
    return Done{};
  }

  /// All candidates, the best of them, what is better in the others, and surgery.
  Result<Labelling> best(const Material& material) {
    const bool one = parameters_.components == Parameters::Components::one;
    if (Status begun = begin("candidates", 0.85); !begun) return std::move(begun).error();
    Result<std::vector<Candidate>> candidates = make_candidates(material, context_);
    if (!candidates) return std::move(candidates).error();
    const std::size_t chosen = best_of(*candidates, one);
    record(*candidates, chosen, material.criterion);

    if (Status begun = begin("fuse", 0.88); !begun) return std::move(begun).error();
    Labelling labels = candidates->at(chosen).labels;
    SurfaceSearch search(material.complex);
    for (std::size_t k = 0; k < candidates->size(); ++k) {
      if (k == chosen) continue;
      result_.statistics.fused_regions += fuse(labels, candidates->at(k).labels, material.criterion, one, search).taken;
    }

    if (Status begun = begin("surgery", 0.92); !begun) return std::move(begun).error();
    if (measure(labels, material.criterion).handles() > 0) {
      const Result<Surgery> surgery = operate(labels, material.criterion, search, context_, context_.threads());
      if (!surgery) return surgery.error();
      result_.statistics.removed_handles = surgery->removed_handles;
    }
    if (Status done = descend_to_end(labels, material.criterion); !done) return std::move(done).error();
    return labels;
  }

  void record(const std::vector<Candidate>& candidates, std::size_t chosen, const Criterion& criterion) {
    MinimumBoundaryStatistics& s = result_.statistics;
    for (const Candidate& c : candidates) {
      s.candidates.push_back({std::string(name_of(c.recipe)), c.measures.components, c.measures.handles(),
                              c.measures.interior, criterion.length(c.measures.energy)});
    }
    const Candidate& winner = candidates[chosen];
    s.chosen_candidate = name_of(winner.recipe);
    s.inflated_cells = winner.inflated.cells;
    s.forced_cells = winner.inflated.forced;
    s.exposed_vertices = winner.descent.exposed;
    s.flipped_edges = winner.descent.flipped;
  }

  void summarise(const Labelling& labels, const Criterion& criterion) {
    const Measures measures = measure(labels, criterion);
    result_.statistics.interior_vertices = measures.interior;
    result_.statistics.components = measures.components;
    result_.statistics.genus = measures.handles();
    result_.statistics.sum_lambda = criterion.length(measures.energy);
  }

  const PointCloud& cloud_;
  const Parameters& parameters_;
  Context& context_;
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
