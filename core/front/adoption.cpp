// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/adoption.hpp"

#include <algorithm>

#include "base/vectors.hpp"

namespace surfaced::front {
namespace {

/// The triangles at every vertex, as it sees them.
struct Corners {
  std::vector<std::uint32_t> first;  // per vertex where its wedges begin
  std::vector<Wedge> wedges;

  std::span<const Wedge> of(std::size_t v) const {
    return {wedges.data() + first[v], static_cast<std::size_t>(first[v + 1] - first[v])};
  }
};

Corners corners_of(const TriangleMesh& mesh) {
  Corners corners;
  corners.first.resize(mesh.positions.size() + 1, 0);
  for (const Triangle& t : mesh.triangles) {
    for (const VertexIndex v : t) ++corners.first[v + 1];
  }
  for (std::size_t v = 1; v < corners.first.size(); ++v) corners.first[v] += corners.first[v - 1];
  corners.wedges.resize(corners.first.back());
  std::vector<std::uint32_t> next(corners.first.begin(), corners.first.end() - 1);
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      corners.wedges[next[t[i]]++] = {t[(i + 1) % 3].value, t[(i + 2) % 3].value};
    }
  }
  return corners;
}

struct Ring {
  std::vector<std::uint32_t> corners;
  bool closed = false;
};

/// The wedges one after the other; empty where they are several fans or more than a star holds.
Ring ring_of(std::span<const Wedge> wedges) {
  Ring ring;
  if (wedges.empty() || wedges.size() >= LocalStars::kLongestStar) return ring;
  const auto begins = [&](const Wedge& w) {
    return std::ranges::find(wedges, w.first, &Wedge::second) == wedges.end();
  };
  auto at = std::ranges::find_if(wedges, begins);
  ring.closed = at == wedges.end();
  if (ring.closed) at = wedges.begin();
  const std::uint32_t start = at->first;
  std::size_t faces = 0;
  for (; at != wedges.end() && faces < wedges.size(); at = std::ranges::find(wedges, at->second, &Wedge::first)) {
    ring.corners.push_back(at->first);
    ++faces;
    if (at->second == start) break;
    if (!ring.closed && faces == wedges.size()) ring.corners.push_back(at->second);
  }
  if (faces < wedges.size() || (ring.closed && faces < 3)) return {};
  return ring;
}

}  // namespace

/// Fills in stars that are given, not found.
class StarGiver {
 public:
  explicit StarGiver(LocalStars& stars, std::size_t blocks) : stars_(stars) { stars_.blocks_.resize(blocks); }

  void operator()(std::size_t v, const Ring& ring) {
    std::vector<std::uint32_t>& list = stars_.blocks_[v / BoxTree::kPointsPerBlock];
    stars_.headers_[v] = {static_cast<std::uint16_t>(list.size()), static_cast<std::uint8_t>(ring.corners.size()),
                          ring.closed};
    list.insert(list.end(), ring.corners.begin(), ring.corners.end());
  }

 private:
  LocalStars& stars_;
};

namespace {

LocalStars stars_of(const TriangleMesh& mesh, std::size_t blocks) {
  LocalStars stars(mesh.positions.size());
  StarGiver give(stars, blocks);
  const Corners corners = corners_of(mesh);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    give(v, ring_of(corners.of(v)));
    Point3 sum{};
    for (const Wedge& w : corners.of(v)) {
      sum += cross(mesh.positions[w.first] - mesh.positions[v], mesh.positions[w.second] - mesh.positions[v]);
    }
    const Point3 normal = direction_of(sum).value_or(Point3{0, 0, 1});
    for (std::size_t k = 0; k < 3; ++k) stars.normals[v][k] = static_cast<float>(normal[k]);
  }
  return stars;
}

/// Every triangle whose three corners have stars.
FaceMasks faces_in_stars(const LocalStars& stars) {
  FaceMasks masks(stars.points(), 0);
  for (std::size_t v = 0; v < stars.points(); ++v) {
    const auto star = stars.star(v);
    for (std::size_t i = 0; i < stars.triangles(v); ++i) {
      const std::size_t next = star[i + 1 < star.size() ? i + 1 : 0];
      if (!stars.star(star[i]).empty() && !stars.star(next).empty()) masks[v] |= 1U << i;
    }
  }
  return masks;
}

}  // namespace

AdoptedMesh::AdoptedMesh(const TriangleMesh& mesh, unsigned threads)
    : tree_(mesh.positions, threads),
      stars_(stars_of(mesh, tree_.blocks())),
      fans_(stars_, faces_in_stars(stars_)),
      places_(tree_, stars_, {}) {
  for (const Triangle& t : mesh.triangles) {
    const bool in_stars = std::ranges::none_of(t, [&](VertexIndex v) { return stars_.star(v).empty(); });
    if (!in_stars) fans_.add({t[0].value, t[1].value, t[2].value});
  }
}

}  // namespace surfaced::front
