#include "cloud/cloud.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <utility>

namespace surfaced {
namespace {

constexpr double kFloatMax = static_cast<double>(std::numeric_limits<float>::max());
constexpr int kMortonBits = 21;

std::string value_text(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

/// First coordinate that no mesh file could hold, or success. Turns -0 into +0.
Status check_and_clean(std::vector<Point3>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& x = positions[i][axis];
      if (std::abs(x) <= kFloatMax) {
        x += 0.0;
        continue;
      }
      const std::string where = std::string("point ") + std::to_string(i) + ": " + "xyz"[axis] + " = " + value_text(x);
      if (!std::isfinite(x)) return Error{ErrorCode::coordinate_not_finite, where + " is not a finite number"};
      return Error{ErrorCode::coordinate_out_of_range,
                   where + " exceeds the largest float32, " + value_text(kFloatMax)};
    }
  }
  return Done{};
}

bool usable(const Normal3& n) {
  const double length =
      std::sqrt(static_cast<double>(n[0]) * n[0] + static_cast<double>(n[1]) * n[1] + static_cast<double>(n[2]) * n[2]);
  return std::isfinite(length) && length > 0;
}

void drop_bad_normals(RawCloud& raw) {
  const auto bad = std::ranges::find_if_not(raw.normals, usable);
  if (bad == raw.normals.end()) return;
  raw.warnings.push_back("normals dropped: that of point " + std::to_string(bad - raw.normals.begin()) +
                         " is not finite or has length 0");
  raw.normals.clear();
}

std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// Morton key on the bounding cube. Scaling by a power of two is exact, so a cloud scaled by one
/// keeps its order.
class MortonGrid {
 public:
  explicit MortonGrid(const Bounds& bounds) : low_(bounds.low) {
    double side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, bounds.high[axis] - bounds.low[axis]);
    int exponent = 0;
    std::frexp(side, &exponent);  // side < 2^exponent
    shift_ = kMortonBits - exponent;
  }

  std::uint64_t key(const Point3& p) const {
    std::uint64_t key = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cell = std::ldexp(p[axis] - low_[axis], shift_);
      const auto clamped = static_cast<std::uint64_t>(std::min(cell, static_cast<double>((1 << kMortonBits) - 1)));
      key |= spread_bits(clamped) << axis;
    }
    return key;
  }

 private:
  Point3 low_;
  int shift_ = 0;
};

struct Entry {
  std::uint64_t key;
  std::uint32_t input;
};

/// Order of the entries: position first; among equal positions the attributes, so that means over
/// duplicates are summed in an order that the file does not decide.
std::vector<Entry> sorted_entries(const RawCloud& raw) {
  const MortonGrid grid(bounds_of(raw.positions));
  std::vector<Entry> entries(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) entries[i] = {grid.key(raw.positions[i]), static_cast<std::uint32_t>(i)};
  std::ranges::sort(entries, [&](const Entry& a, const Entry& b) {
    if (a.key != b.key) return a.key < b.key;
    if (raw.positions[a.input] != raw.positions[b.input]) return raw.positions[a.input] < raw.positions[b.input];
    if (!raw.normals.empty() && raw.normals[a.input] != raw.normals[b.input]) {
      return raw.normals[a.input] < raw.normals[b.input];
    }
    if (!raw.colors.empty() && raw.colors[a.input] != raw.colors[b.input])
      return raw.colors[a.input] < raw.colors[b.input];
    return a.input < b.input;
  });
  return entries;
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

Result<PointCloud> make_cloud(RawCloud raw) {
  if (Status checked = check_and_clean(raw.positions); !checked) return std::move(checked).error();
  drop_bad_normals(raw);
  const std::vector<Entry> entries = sorted_entries(raw);
  PointCloud cloud;
  cloud.warnings = std::move(raw.warnings);
  cloud.input_to_vertex.resize(raw.size());
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    const Point3& position = raw.positions[entries[begin].input];
    const VertexIndex vertex(cloud.positions.size());
    for (end = begin; end < entries.size() && raw.positions[entries[end].input] == position; ++end) {
      cloud.input_to_vertex[entries[end].input] = vertex;
    }
    cloud.positions.push_back(position);
    const Entry* first = entries.data() + begin;
    const Entry* last = entries.data() + end;
    if (!raw.normals.empty()) cloud.normals.push_back(mean_normal(raw, first, last));
    if (!raw.colors.empty()) cloud.colors.push_back(mean_color(raw, first, last));
  }
  if (cloud.size() < raw.size()) {
    cloud.warnings.push_back(std::to_string(raw.size() - cloud.size()) + " duplicate points merged");
  }
  return cloud;
}

}  // namespace surfaced
