// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/warnings.hpp"

#include <cmath>

#include "base/text.hpp"
#include "minimum_boundary/doubt.hpp"
#include "minimum_boundary/solid_angles.hpp"

namespace surfaced::boundary {
namespace {

/// Share of the area over openings beyond which closing is a guess.
constexpr double kDoubtfulSheets = 0.02;
/// Handles per point beyond which they look like noise, unless they are few.
constexpr double kDoubtfulHandles = 0.01;
constexpr std::int64_t kFewHandles = 10;
/// Share of the vertices with ε above 1 from which on the points show hardly more than the corners of a shape; right
/// random parts of clouds have 0.34 at most.
constexpr double kUndersampled = 0.4;
/// Share of the points that may lie inside without a word.
constexpr double kFewInside = 0.005;

void doubt_components(const MinimumBoundaryStatistics& s, const MinimumBoundaryParameters& parameters,
                      std::vector<std::string>& warnings) {
  if (parameters.components == MinimumBoundaryParameters::Components::many) return;
  if (s.bodies > 0 && s.components > s.bodies) {
    warnings.push_back("components_remaining: " + std::to_string(s.components) +
                       " components are left that no chain of cells could join");
  }
  if (s.joined_parts > s.components) {
    warnings.push_back("components_joined: " + std::to_string(s.joined_parts) +
                       " parts lie more than ten times as far apart as their points and were joined; "
                       "components=many keeps separate objects separate");
  } else if (s.bodies_seen > s.components) {
    warnings.push_back("components_joined: the points look like " + std::to_string(s.bodies_seen) +
                       " closed bodies and were joined; components=auto or many keeps them separate");
  }
}

void doubt_volume(const MinimumBoundaryStatistics& s, std::size_t points, std::vector<std::string>& warnings) {
  const std::size_t on_surface = points - s.interior_vertices;
  const double thin = static_cast<double>(s.thin_vertices) / static_cast<double>(on_surface);
  if (thin > SolidAngles::cage_share(on_surface)) {
    warnings.push_back(
        "volume_uncertain: at " + percent(thin) +
        " of the vertices the surface turns back upon itself and encloses next to nothing; the cloud may "
        "be noisy (smooth=bilateral) or an open sheet (local-delaunay)");
  }
  if (static_cast<double>(s.interior_vertices) > kFewInside * static_cast<double>(points)) {
    warnings.push_back("points_inside: " + std::to_string(s.interior_vertices) + " of " + std::to_string(points) +
                       " points lie inside the surface");
  }
  if (s.outliers > 0) {
    warnings.push_back("outliers_suspected: " + std::to_string(s.outliers) +
                       " points lie more than eight times as far from all others as those from each other and make "
                       "spikes; outliers=3 removes them");
  }
}

void doubt_topology(const MinimumBoundaryStatistics& s, std::size_t points, std::vector<std::string>& warnings) {
  const double handles = static_cast<double>(s.genus) / static_cast<double>(points);
  if (handles > kDoubtfulHandles && s.genus > kFewHandles) {
    warnings.push_back("topology_uncertain: " + std::to_string(s.genus) + " handles for " + std::to_string(points) +
                       " points; the cloud may be noisy");
  } else if (s.doubt && *s.doubt > kDoubtful) {
    warnings.push_back("topology_uncertain: genus, components or volume are wrong with a probability of " +
                       percent(*s.doubt) + ", by how far different ways to them agree; see evidence in the report");
  }
}

}  // namespace

std::vector<std::string> warnings_of(const MinimumBoundaryStatistics& statistics,
                                     const MinimumBoundaryParameters& parameters, std::size_t points) {
  std::vector<std::string> warnings;
  if (statistics.sheet_area_share > kDoubtfulSheets) {
    warnings.push_back("closure_uncertain: " + percent(statistics.sheet_area_share) +
                       " of the area spans openings more than ten times as wide as the points lie apart");
  }
  doubt_components(statistics, parameters, warnings);
  doubt_volume(statistics, points, warnings);
  if (statistics.sampling && statistics.sampling->share_above_one > kUndersampled) {
    warnings.push_back("sampling_uncertain: at " + percent(statistics.sampling->share_above_one) +
                       " of the vertices the points lie farther apart than the shape is deep; several bodies fit them");
  }
  doubt_topology(statistics, points, warnings);
  return warnings;
}

}  // namespace surfaced::boundary
