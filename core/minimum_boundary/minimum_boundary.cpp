#include "minimum_boundary/minimum_boundary.hpp"

#include <new>

#include "minimum_boundary/ball_ratio.hpp"
#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/labelling.hpp"
#include "minimum_boundary/measures.hpp"
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

/// OUT is the cluster of the infinite cells.
std::vector<std::uint8_t> inside_of(const Clusters& clusters) {
  std::vector<std::uint8_t> in(clusters.cluster.size());
  for (std::size_t c = 0; c < in.size(); ++c) in[c] = clusters.cluster[c] != clusters.outside ? 1 : 0;
  return in;
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

    context_.enter("boundary-complex", 0.65);
    const bool connected = parameters_.components == Parameters::Components::one;
    Result<BoundaryComplex> boundary = boundary_complex(*complex, criterion, connected, context_);
    if (!boundary) return std::move(boundary).error();
    result_.statistics.boundary_complex_facets = boundary->size;
    result_.statistics.reinserted_facets = boundary->reinserted;
    if (parameters_.stop_after == Parameters::StopAfter::boundary_complex) {
      result_.mesh = mesh_of(*complex, boundary->facets, cloud_);
      return std::move(result_);
    }

    Result<std::vector<std::uint8_t>> inside = label(*complex, *boundary);
    if (!inside) return std::move(inside).error();
    Labelling labels(*complex);
    labels.assign(*inside, context_.threads());
    *inside = {};
    if (Status finished = finish(labels, *boundary, criterion); !finished) return std::move(finished).error();
    return std::move(result_);
  }

 private:
  Result<std::vector<std::uint8_t>> label(const DelaunayComplex& complex, const BoundaryComplex& boundary) {
    if (parameters_.lids == Parameters::Lids::none) return cells_behind(complex, boundary.facets);
    context_.enter("watershed", 0.8);
    const BallRatio ratio(complex, context_.threads());
    Result<Watershed> watershed = guarded_watershed(complex, boundary, ratio, context_);
    if (!watershed) return std::move(watershed).error();
    return inside_of(watershed->at_level.back());
  }

  Status finish(Labelling& labels, const BoundaryComplex& boundary, const Criterion& criterion) {
    context_.enter("inflate", 0.9);
    const Result<Inflated> inflated = inflate(labels, boundary.facets, criterion, context_);
    if (!inflated) return inflated.error();
    result_.statistics.inflated_cells = inflated->cells;
    result_.statistics.forced_cells = inflated->forced;

    if (parameters_.stop_after != Parameters::StopAfter::inflated) {
      context_.enter("descent", 0.95);
      const Result<Descent> descent = descend(labels, criterion, context_);
      if (!descent) return descent.error();
      result_.statistics.exposed_vertices = descent->exposed;
      result_.statistics.flipped_edges = descent->flipped;
    }

    context_.enter("surface", 1);
    const Measures measures = measure(labels, criterion);
    result_.statistics.interior_vertices = measures.interior;
    result_.statistics.components = measures.components;
    result_.statistics.genus = measures.handles();
    result_.statistics.sum_lambda = criterion.length(measures.energy);
    result_.mesh = surface_of(labels, cloud_);
    return Done{};
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
