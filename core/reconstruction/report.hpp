// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: measurements as the JSON of proto/schema/report.json.
#pragma once

#include <optional>
#include <vector>

#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "quality/quality.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

Json cloud_json(const PointCloud& cloud);
Json topology_json(const Topology& topology);

/// How the points of a cloud relate to a mesh.
struct PointUse {
  std::size_t unused = 0;
  /// Unused points inside; none if the mesh is open or its method does not interpolate.
  std::optional<std::size_t> interior;
};
Json quality_json(const MeshQuality& quality, const std::optional<PointUse>& use,
                  const std::optional<std::size_t>& self_intersections);

Json certificate_json(const Certificate& certificate);

/// What is to be said of a certificate among the warnings.
std::vector<std::string> certificate_warnings(const Certificate& certificate);

Json stages_json(const std::vector<Stage>& stages);

}  // namespace surfaced
