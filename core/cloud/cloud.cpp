// SPDX-License-Identifier: GPL-3.0-or-later
#include "cloud/cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/measurements.hpp"
#include "cloud/order.hpp"

namespace surfaced {
namespace {

bool usable(const Normal3& n) {
  const double length =
      std::sqrt(static_cast<double>(n[0]) * n[0] + static_cast<double>(n[1]) * n[1] + static_cast<double>(n[2]) * n[2]);
  return std::isfinite(length) && length > 0;
}

void drop_bad_normals(RawCloud& raw) {
  const auto bad = std::ranges::find_if_not(raw.normals, usable);
  if (bad == raw.normals.end()) return;
  const auto count = raw.normals.end() - bad - std::count_if(bad, raw.normals.end(), usable);
  raw.warnings.push_back("normals dropped: " + std::to_string(count) + " of " + std::to_string(raw.normals.size()) +
                         " are not finite or have length 0, the first that of point " +
                         std::to_string(bad - raw.normals.begin()));
  raw.normals.clear();
}

Normal3 mean_normal(const RawCloud& raw, const Entry* first, const Entry* last) {
  if (last - first == 1) return raw.normals[first->input];
  Point3 sum{};
  for (const Entry* e = first; e != last; ++e) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += static_cast<double>(raw.normals[e->input][axis]);
  }
  const double length = norm(sum);
  if (!(length > 0)) return raw.normals[first->input];
  return {static_cast<float>(sum[0] / length), static_cast<float>(sum[1] / length),
          static_cast<float>(sum[2] / length)};
}

Color4 mean_color(const RawCloud& raw, const Entry* first, const Entry* last) {
  const auto count = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(last - first));
  std::array<std::uint64_t, 4> sum{};
  for (const Entry* e = first; e != last; ++e) {
    for (std::size_t c = 0; c < 4; ++c) sum[c] += raw.colors[e->input][c];
  }
  Color4 mean{};
  for (std::size_t c = 0; c < 4; ++c) mean[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
  return mean;
}

/// Keeps one of equal positions, which follow one another, and the means of their attributes.
void merge_duplicates(const RawCloud& raw, const std::vector<Entry>& entries, PointCloud& cloud) {
  cloud.input_to_vertex.resize(entries.size());
  cloud.normals.reserve(raw.normals.size());
  cloud.colors.reserve(raw.colors.size());
  std::size_t count = 0;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    const Point3 position = cloud.positions[begin];
    for (end = begin; end < entries.size() && cloud.positions[end] == position; ++end) {
      cloud.input_to_vertex[entries[end].input] = VertexIndex(count);
    }
    cloud.positions[count++] = position;
    const Entry* first = entries.data() + begin;
    const Entry* last = entries.data() + end;
    if (!raw.normals.empty()) cloud.normals.push_back(mean_normal(raw, first, last));
    if (!raw.colors.empty()) cloud.colors.push_back(mean_color(raw, first, last));
  }
  cloud.positions.resize(count);
}

}  // namespace

Bounds bounds_of(const std::vector<Point3>& positions) {
  if (positions.empty()) return {};
  Bounds bounds{positions.front(), positions.front()};
  for (const Point3& p : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min(bounds.low[axis], p[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], p[axis]);
    }
  }
  return bounds;
}

Result<PointCloud> make_cloud(RawCloud raw, unsigned threads, Missing missing) {
  const std::size_t rows = raw.size();
  const Result<std::vector<std::uint32_t>> kept = keep_measured(raw, missing);
  if (!kept) return kept.error();
  drop_bad_normals(raw);
  const std::vector<Entry> entries = canonical_order(raw, threads);
  PointCloud cloud;
  cloud.warnings = std::move(raw.warnings);
  cloud.source = std::move(raw.source);
  cloud.missing = rows - raw.size();
  cloud.positions.resize(raw.size());
  parallel_ranges(threads, raw.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) cloud.positions[i] = raw.positions[entries[i].input];
  });
  raw.positions = {};
  merge_duplicates(raw, entries, cloud);
  if (cloud.size() < entries.size()) {
    cloud.warnings.push_back(std::to_string(entries.size() - cloud.size()) + " duplicate points merged");
  }
  if (cloud.missing > 0) {
    std::vector<VertexIndex> of_rows(rows);
    for (std::size_t i = 0; i < kept->size(); ++i) of_rows[(*kept)[i]] = cloud.input_to_vertex[i];
    cloud.input_to_vertex = std::move(of_rows);
  }
  return cloud;
}

}  // namespace surfaced
