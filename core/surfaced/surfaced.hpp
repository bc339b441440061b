// SPDX-License-Identifier: GPL-3.0-or-later
// All that the library offers: clouds, methods, meshes, files, measures. A program that links surfaced::core (CMake) or
// takes `pkg-config surfaced` includes this and nothing else:
//
//   #include <surfaced/surfaced.hpp>
//
//   surfaced::RawCloud points;                                          // 1. points, from anywhere
//   points.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
//   const auto cloud = surfaced::make_cloud(std::move(points));         // 2. distinct, sorted; or an error
//   const auto method = surfaced::find_method("minimum-boundary");
//   const auto parameters = surfaced::check_parameters(**method, surfaced::Json::object());
//   surfaced::Context context;                                          // 3. threads, progress, cancelling
//   const auto made = surfaced::run(*cloud, **method, *parameters, context);
//   // made->mesh: positions and triangles; vertices_of_input(*cloud, made->mesh): which point became which vertex
//
// Errors are values (surfaced::Result): test each with `if (!made) ... made.error().detail`. Nothing is thrown.
#pragma once

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "io/io.hpp"
#include "mesh/mesh.hpp"
#include "reconstruction/input_vertices.hpp"
#include "reconstruction/reconstruction.hpp"
