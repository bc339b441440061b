// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the table of methods behind the façade.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// A method's face and its engine. The mesh of an engine that interpolates has vertex v = point v of the cloud, then
/// invented vertices if the method makes any; that of another has vertices of its own.
struct Method {
  MethodInfo info;
  /// Whether all vertices are input points, so that points inside the mesh can be told from its vertices.
  bool interpolates;
  /// Whether its reports carry a certificate.
  bool certified = false;
  /// What a point usually takes, with the measurement and the writing of the mesh. Unmeasured, a generous guess.
  Cost of_a_point{.seconds = 1e-3, .bytes = 8 << 10};
  Result<Reconstruction> (*engine)(const PointCloud&, const Json& parameters, Context&);
};

/// The method behind a MethodInfo from methods().
const Method& method_of(const MethodInfo& info);

Method minimum_boundary_method();
Method local_delaunay_method();
Method intrinsic_delaunay_method();
Method advancing_front_method();
Method scale_space_method();
Method poisson_method();
Method alpha_wrap_method();

/// A method's schema: its own properties and those that every method has.
Json schema_of(Json properties);

}  // namespace surfaced
