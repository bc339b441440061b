// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what the methods have in common.
#pragma once

#include <new>
#include <string>
#include <utility>
#include <vector>

#include "base/library_failure.hpp"
#include "baselines/baselines.hpp"
#include "baselines/watch.hpp"

namespace surfaced::baselines {

/// The steps that a method may take: some hundred times what it usually does.
constexpr std::uint64_t most_steps(std::size_t points) {
  constexpr std::uint64_t kAlways = 50'000'000;
  constexpr std::uint64_t kPerPoint = 500'000;
  return kAlways + kPerPoint * points;
}

/// Runs a method and turns what CGAL throws into errors.
template <class Work>
auto guarded(const char* method, const PointCloud& cloud, const Context& context, Work work) -> decltype(work()) {
  try {
    const Watch watch(context, most_steps(cloud.size()));
    return work();
  } catch (const Cancelled&) {
    return Error{ErrorCode::cancelled, std::string("cancelled during ") + method};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, std::string(method) + " over " + std::to_string(cloud.size()) +
                                               " points needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{ErrorCode::method_failed, std::string("CGAL's ") + method + " failed: " + reason_of(failure)};
  }
}

/// too_few_points unless the cloud has as many.
Status check_points(const PointCloud& cloud, std::size_t fewest, const char* method);

/// Gives every vertex the normal and the colour of the input point nearest to it, where the cloud has them. Of
/// points equally near it is always the same one.
void carry_attributes(const PointCloud& cloud, TriangleMesh& mesh, unsigned threads);

/// Numbers the vertices by their coordinates and sorts the triangles, so that nothing remains of the order in which
/// the library found them; drops vertices without a triangle.
void sort_mesh(TriangleMesh& mesh);

/// Drops the triangles at every vertex but those of its largest fan, until each vertex has one.
void drop_pinched_fans(TriangleMesh& mesh);

}  // namespace surfaced::baselines
