// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what the stages have in common.
#pragma once

#include <new>
#include <string>
#include <utility>
#include <vector>

#include "base/library_failure.hpp"
#include "preparing/preparing.hpp"

namespace surfaced::preparing {

/// Runs a stage and turns what it throws into errors.
template <class T, class Work>
Result<T> guarded(const char* stage, Context& context, Work work) {
  try {
    Result<T> result = work();
    if (context.cancelled()) return Error{ErrorCode::cancelled, std::string("cancelled during ") + stage};
    return result;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, std::string(stage) + " needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{ErrorCode::method_failed, std::string(stage) + " failed: " + reason_of(failure)};
  }
}

/// The points named by ascending indices, with their attributes.
inline Result<PointCloud> chosen(const PointCloud& cloud, const std::vector<std::size_t>& kept, unsigned threads) {
  RawCloud raw;
  for (const std::size_t v : kept) {
    raw.positions.push_back(cloud.positions[v]);
    if (!cloud.normals.empty()) raw.normals.push_back(cloud.normals[v]);
    if (!cloud.colors.empty()) raw.colors.push_back(cloud.colors[v]);
  }
  raw.warnings = cloud.warnings;
  return make_cloud(std::move(raw), threads);
}

}  // namespace surfaced::preparing
