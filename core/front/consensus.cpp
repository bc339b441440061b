// SPDX-License-Identifier: GPL-3.0-or-later
// Pre-pass of paper 2's front: triangles that the local triangulations of all three vertices contain.
#include "front/consensus.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/parallel.hpp"
#include "base/sided_sets.hpp"

namespace surfaced::front {
namespace {

constexpr std::uint32_t kNone = VertexIndex::kNone;

/// The vertices before and after w in the star of v; none beyond the ends of an open star.
struct Beside {
  std::uint32_t before = kNone;
  std::uint32_t after = kNone;
};

Beside beside(const LocalStars& stars, std::size_t v, std::uint32_t w) {
  const auto star = stars.star(v);
  for (std::size_t i = 0; i < star.size(); ++i) {
    if (star[i] != w) continue;
    const bool closed = stars.closed(v);
    Beside b;
    if (i > 0 || closed) b.before = star[i > 0 ? i - 1 : star.size() - 1];
    if (i + 1 < star.size() || closed) b.after = star[i + 1 < star.size() ? i + 1 : 0];
    return b;
  }
  return {};
}

/// StarCorners i and i+1 of the star.
struct StarCorners {
  std::uint32_t first;
  std::uint32_t second;
};
StarCorners corners(std::span<const std::uint32_t> star, std::size_t i) {
  return {star[i], star[i + 1 < star.size() ? i + 1 : 0]};
}

std::uint32_t mask_of(const LocalStars& stars, std::size_t v) {
  const auto star = stars.star(v);
  const std::size_t count = stars.triangles(v);
  std::uint32_t in_first = 0;   // triangle i is in the star of its first corner
  std::uint32_t in_second = 0;  // and of its second
  for (std::size_t i = 0; i < star.size(); ++i) {
    const Beside b = beside(stars, star[i], static_cast<std::uint32_t>(v));
    if (i < count) {
      const std::uint32_t next = corners(star, i).second;
      if (next == b.before || next == b.after) in_first |= 1U << i;
    }
    const std::size_t previous = i > 0 ? i - 1 : star.size() - 1;
    if (previous < count) {
      const std::uint32_t other = star[previous];
      if (other == b.before || other == b.after) in_second |= 1U << previous;
    }
  }
  return in_first & in_second;
}

/// Whether triangle (v, first, second) has the opposite orientation in the star of `first`, and of `second`.
struct Turned {
  bool at_first;
  bool at_second;
};
Turned turned(const LocalStars& stars, std::uint32_t v, StarCorners c) {
  return {beside(stars, c.first, v).before != c.second, beside(stars, c.second, v).after != c.first};
}

/// Takes face i of v, with corners c, from the masks of its three vertices.
void drop_face(const LocalStars& stars, FaceMasks& faces, std::uint32_t v, StarCorners c) {
  const std::array<std::uint32_t, 3> all{v, c.first, c.second};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto star = stars.star(all[k]);
    for (std::size_t i = 0; i < stars.triangles(all[k]); ++i) {
      const StarCorners d = corners(star, i);
      const bool same = (d.first == all[(k + 1) % 3] && d.second == all[(k + 2) % 3]) ||
                        (d.second == all[(k + 1) % 3] && d.first == all[(k + 2) % 3]);
      if (same) faces[all[k]] &= ~(1U << i);
    }
  }
}

std::uint32_t full_mask(std::size_t triangles) { return triangles >= 32 ? 0xFFFFFFFFU : (1U << triangles) - 1; }

double parallelism(const LocalStars& stars, std::uint32_t a, std::uint32_t b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += static_cast<double>(stars.normals[a][k]) * static_cast<double>(stars.normals[b][k]);
  }
  return sum;
}

/// Least agreement, from -1 to 1, of the normals at the corners of the face with how the stars there turn it: low where
/// noise folds the surface over.
double certainty(const LocalStars& stars, std::uint32_t v, StarCorners c, Turned t) {
  const auto agreement = [&](std::uint32_t a, std::uint32_t b, bool turned_over) {
    return turned_over ? -parallelism(stars, a, b) : parallelism(stars, a, b);
  };
  return std::min({agreement(v, c.first, t.at_first), agreement(v, c.second, t.at_second),
                   agreement(c.first, c.second, t.at_first != t.at_second)});
}

/// The surest faces first: of faces that contradict each other the more doubtful ones go, instead of a slit along which
/// two parts meet that others have turned.
std::size_t unite_across_faces(const LocalStars& stars, FaceMasks& faces, SidedSets& sets) {
  constexpr double kSure = 0.8;
  struct Doubtful {
    double certainty;
    std::uint32_t v;
    StarCorners c;
    Turned t;
  };
  std::vector<Doubtful> doubtful;
  std::size_t dropped = 0;
  const auto unite = [&](std::uint32_t v, StarCorners c, Turned t) {
    if (sets.unite(v, c.first, t.at_first ? 1 : 0) && sets.unite(v, c.second, t.at_second ? 1 : 0)) return;
    drop_face(stars, faces, v, c);
    ++dropped;
  };
  for (std::uint32_t v = 0; v < stars.points(); ++v) {
    const auto star = stars.star(v);
    for (std::size_t i = 0; i < stars.triangles(v); ++i) {
      if ((faces[v] >> i & 1U) == 0) continue;
      const StarCorners c = corners(star, i);
      if (v > c.first || v > c.second) continue;
      const Turned t = turned(stars, v, c);
      const double sure = certainty(stars, v, c, t);
      if (sure >= kSure) {
        unite(v, c, t);
      } else {
        doubtful.push_back({sure, v, c, t});
      }
    }
  }
  std::ranges::stable_sort(doubtful, std::ranges::greater(), &Doubtful::certainty);
  for (const Doubtful& d : doubtful) unite(d.v, d.c, d.t);
  return dropped;
}

void unite_across_shared_triangles(const LocalStars& stars, const FaceMasks& faces, SidedSets& sets) {
  for (std::uint32_t v = 0; v < stars.points(); ++v) {
    if (faces[v] == full_mask(stars.triangles(v))) continue;
    const auto star = stars.star(v);
    for (std::size_t i = 0; i < stars.triangles(v); ++i) {
      if ((faces[v] >> i & 1U) != 0) continue;
      const StarCorners c = corners(star, i);
      const Beside at_first = beside(stars, c.first, v);
      if (at_first.before == c.second || at_first.after == c.second)
        sets.unite(v, c.first, at_first.before == c.second ? 0 : 1);
      const Beside at_second = beside(stars, c.second, v);
      if (at_second.before == c.first || at_second.after == c.first)
        sets.unite(v, c.second, at_second.after == c.first ? 0 : 1);
    }
  }
}

void unite_along_edges(const LocalStars& stars, const FaceMasks& faces, SidedSets& sets) {
  struct Link {
    double strength;
    std::uint32_t a;
    std::uint32_t b;
  };
  std::vector<Link> links;
  for (std::uint32_t v = 0; v < stars.points(); ++v) {
    if (faces[v] == full_mask(stars.triangles(v))) continue;
    for (const std::uint32_t w : stars.star(v)) {
      if (sets.apart(v, w)) links.push_back({std::abs(parallelism(stars, v, w)), v, w});
    }
  }
  std::ranges::sort(links, [](const Link& x, const Link& y) {
    if (x.strength != y.strength) return x.strength > y.strength;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  for (const Link& link : links) sets.unite(link.a, link.b, parallelism(stars, link.a, link.b) < 0 ? 1 : 0);
}

/// The mask of a star that was turned over: its corners now run the other way.
std::uint32_t turned_mask(std::uint32_t mask, std::size_t count, std::size_t corners_count) {
  std::uint32_t turned = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Triangle (i, i+1) becomes the one at corners n-2-i, n-1-i.
    const std::size_t at = (2 * corners_count - 2 - i) % corners_count;
    if ((mask >> i & 1U) != 0) turned |= 1U << at;
  }
  return turned;
}

}  // namespace

FaceMasks agreed_faces(const LocalStars& stars, unsigned threads) {
  FaceMasks faces(stars.points());
  parallel_ranges(threads, stars.points(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) faces[v] = mask_of(stars, v);
  });
  return faces;
}

std::size_t orient(LocalStars& stars, FaceMasks& faces) {
  SidedSets sets(stars.points());
  const std::size_t dropped = unite_across_faces(stars, faces, sets);
  unite_across_shared_triangles(stars, faces, sets);
  unite_along_edges(stars, faces, sets);
  for (std::uint32_t v = 0; v < stars.points(); ++v) {
    if ((sets.find(v) & 1U) == 0) continue;
    faces[v] = turned_mask(faces[v], stars.triangles(v), stars.star(v).size());
    stars.turn_over(v);
  }
  return dropped;
}

}  // namespace surfaced::front
