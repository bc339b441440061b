// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh in memory to its files and its report.
#pragma once

#include "reconstruction/reconstruction.hpp"
#include "reconstruction/report.hpp"

namespace surfaced {

/// Distinct points of the cloud that no triangle of the mesh uses. A point is a vertex if it equals one
/// after both are rounded to float32, the precision of mesh files.
PointUse use_of_points(const PointCloud& cloud, const TriangleMesh& mesh, const Topology& topology, bool interpolates);

std::vector<std::string> warnings_of_openings(const Json& topology);

/// Encodes the mesh, measures the decoded file and writes it, then the further files that the request names; returns
/// the reproducible report.
Result<Json> deliver(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                     const Reconstruction& result, MeshFormat format, Context& context);

/// The report where only points are asked for: of the mesh as computed.
Result<Json> measure_unwritten(const FileRequest& request, const PointCloud& cloud, const Json& preparing,
                               const Reconstruction& result, Context& context);

}  // namespace surfaced
