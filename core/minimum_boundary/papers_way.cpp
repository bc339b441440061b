// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/papers_way.hpp"

#include "minimum_boundary/conforming.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/min_cut.hpp"
#include "minimum_boundary/sculpturing.hpp"

namespace surfaced::boundary {
namespace {

using Lids = MinimumBoundaryParameters::Lids;

Result<Covered> covered_by(Lids lids, const LidCase& c, const Labelling& labels, Context& context) {
  const FacetSet& facets = c.boundary.facets;
  switch (lids) {
    case Lids::none:
      return Covered{facets};
    case Lids::ball:
      return cover_by_balls(c.complex, facets, c.parameters.delta, context);
    case Lids::mincut:
      return cover_by_cut(c.complex, facets, c.criterion, c.parameters.delta, context);
    case Lids::watershed:
    case Lids::paper:
      break;
  }
  return cover_by_artifacts(Walls{labels, facets}, c.criterion);
}

}  // namespace

Result<Covered> cover(const LidCase& c, const Labelling& labels, MinimumBoundaryStatistics& statistics,
                      Context& context) {
  if (Status begun = context.begin("cover-holes", 0.75); !begun) return std::move(begun).error();
  Result<Covered> covered = covered_by(c.parameters.lids, c, labels, context);
  if (!covered) return covered;
  statistics.lids = covered->lids;
  statistics.artifacts = covered->artifacts;
  statistics.hull_holes = covered->hull_holes;
  statistics.delta = covered->delta;
  statistics.seed_factor = covered->seed_factor;
  return covered;
}

Result<Labelling> papers_way(const LidCase& c, MinimumBoundaryStatistics& statistics, Context& context) {
  Labelling labels(c.complex);
  labels.assign(cells_behind(c.complex, c.boundary.facets), context.threads());
  if (Status begun = context.begin("conform", 0.7); !begun) return std::move(begun).error();
  const Result<std::size_t> conforming = make_conforming(labels, c.boundary.facets, c.criterion, context);
  if (!conforming) return conforming.error();
  statistics.conforming_cells = *conforming;

  const Result<Covered> covered = cover(c, labels, statistics, context);
  if (!covered) return covered.error();
  std::vector<std::uint8_t> in = cells_behind(c.complex, covered->facets);
  for (std::size_t k = 0; k < in.size(); ++k) in[k] = in[k] != 0 || labels.in(CellIndex(k)) ? 1 : 0;
  labels.assign(in, context.threads());

  if (Status begun = context.begin("inflate", 0.85); !begun) return std::move(begun).error();
  const Result<Inflated> inflated = inflate(labels, covered->facets, c.criterion, context, context.threads());
  if (!inflated) return inflated.error();
  statistics.inflated_cells = inflated->cells;
  statistics.forced_cells = inflated->forced;
  if (c.parameters.stop_after == MinimumBoundaryParameters::StopAfter::inflated) return labels;

  if (Status begun = context.begin("sculpture", 0.95); !begun) return std::move(begun).error();
  const Result<Sculptured> sculptured = sculpture(labels, covered->facets, c.criterion, context);
  if (!sculptured) return sculptured.error();
  statistics.exposed_vertices = sculptured->exposed;
  statistics.flipped_edges = sculptured->flipped;
  return labels;
}

}  // namespace surfaced::boundary
