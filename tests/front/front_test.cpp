// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/front.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "support/holes.hpp"
#include "support/nasty_clouds.hpp"

namespace surfaced::front {
namespace {

/// Stars and agreed faces of a cloud, oriented.
struct Fixture {
  explicit Fixture(const std::vector<Point3>& points, StarKind kind = StarKind::restricted)
      : cloud(*make_cloud(testing::raw_cloud(points))), tree(cloud.positions, 1), stars(make(kind)) {
    faces = agreed_faces(stars, 1);
    dropped = orient(stars, faces);
  }
  LocalStars make(StarKind kind) const {
    Context context;
    return *local_stars(tree, {.kind = kind, .neighbours = 16}, context);
  }

  PointCloud cloud;
  BoxTree tree;
  LocalStars stars;
  FaceMasks faces;
  std::size_t dropped = 0;
};

std::vector<Point3> noisy_sphere(std::size_t n, double noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> off(0, noise);
  auto points = testing::sphere_points(n);
  for (Point3& p : points) {
    for (double& x : p) x += off(random);
  }
  return points;
}

TEST(LocalStars, every_star_has_distinct_corners_none_of_them_its_centre) {
  for (std::uint64_t number = 0; number < 800; ++number) {
    const auto points = testing::NastyClouds::make(number).points;
    if (make_cloud(testing::raw_cloud(points))->size() < 3) continue;
    const Fixture f(points, number % 2 == 0 ? StarKind::restricted : StarKind::unfolded);
    for (std::size_t v = 0; v < f.stars.points(); ++v) {
      const auto star = f.stars.star(v);
      const std::set<std::uint32_t> corners(star.begin(), star.end());
      ASSERT_EQ(corners.size(), star.size()) << number;
      ASSERT_FALSE(corners.contains(static_cast<std::uint32_t>(v)));
      ASSERT_TRUE(!f.stars.closed(v) || star.size() >= 3);
    }
  }
}

TEST(LocalStars, normals_of_a_sphere_point_along_its_radii) {
  const Fixture f(testing::sphere_points(3000));
  for (std::size_t v = 0; v < f.stars.points(); ++v) {
    const Normal3& n = f.stars.normals[v];
    const Point3& p = f.cloud.positions[v];
    const double along =
        static_cast<double>(n[0]) * p[0] + static_cast<double>(n[1]) * p[1] + static_cast<double>(n[2]) * p[2];
    EXPECT_GT(std::abs(along), 0.999);
  }
}

/// Triangles on which three stars agree, by looking each one up in the others.
std::set<Face> slow_agreed(const LocalStars& stars) {
  std::map<Face, int> votes;
  for (std::uint32_t v = 0; v < stars.points(); ++v) {
    const auto star = stars.star(v);
    for (std::size_t i = 0; i < stars.triangles(v); ++i) {
      Face face{v, star[i], star[(i + 1) % star.size()]};
      std::ranges::sort(face);
      ++votes[face];
    }
  }
  std::set<Face> agreed;
  for (const auto& [face, count] : votes) {
    if (count == 3) agreed.insert(face);
  }
  return agreed;
}

TEST(AgreedFaces, are_those_that_all_three_stars_contain) {
  for (const double noise : {0.0, 0.01, 0.05}) {
    const Fixture f(noisy_sphere(1500, noise, 1));
    const std::set<Face> expected = slow_agreed(f.stars);
    const Fans fans(f.stars, f.faces);
    std::set<Face> found;
    for (const Triangle& t : fans.triangles()) {
      Face face{t[0].value, t[1].value, t[2].value};
      std::ranges::sort(face);
      found.insert(face);
    }
    EXPECT_EQ(found.size() + f.dropped, expected.size());
    EXPECT_TRUE(std::ranges::includes(expected, found));
    EXPECT_EQ(fans.faces(), found.size());
  }
}

TEST(AgreedFaces, are_edge_manifold_and_consistently_oriented_on_every_nasty_cloud) {
  for (std::uint64_t number = 0; number < 1500; ++number) {
    const auto points = testing::NastyClouds::make(number).points;
    if (make_cloud(testing::raw_cloud(points))->size() < 3) continue;
    const Fixture f(points);
    TriangleMesh mesh{f.cloud.positions, Fans(f.stars, f.faces).triangles(), {}, {}};
    const Topology topology = topology_of(mesh);
    ASSERT_TRUE(topology.edge_manifold) << number;
    ASSERT_TRUE(topology.oriented) << number;
  }
}

TEST(AgreedFaces, do_not_depend_on_the_number_of_threads) {
  const Fixture one(noisy_sphere(20000, 0.001, 2));
  Context context(3);
  LocalStars stars = *local_stars(one.tree, {}, context);
  FaceMasks faces = agreed_faces(stars, 3);
  orient(stars, faces);
  EXPECT_EQ(faces, one.faces);
  EXPECT_EQ(stars.normals, one.stars.normals);
}

TEST(Fans, undo_restores_the_faces_of_the_mark) {
  const Fixture f(noisy_sphere(600, 0.02, 3));
  Fans fans(f.stars, f.faces);
  const auto before = fans.triangles();
  const std::size_t mark = fans.mark();
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const auto all = fans.triangles();
    const Triangle& t = all[random() % all.size()];
    fans.remove({t[0].value, t[1].value, t[2].value});
  }
  EXPECT_EQ(fans.faces(), before.size() - 100);
  fans.undo(mark);
  EXPECT_EQ(fans.triangles(), before);
  EXPECT_EQ(fans.faces(), before.size());
}

TEST(Fans, know_their_open_edges) {
  const Fixture f(testing::sphere_points(400));
  Fans fans(f.stars, f.faces);
  const auto all = fans.triangles();
  ASSERT_FALSE(all.empty());
  const Face face{all[0][0].value, all[0][1].value, all[0][2].value};
  const bool settled = fans.around(face[0]) == Around::closed;
  fans.remove(face);
  std::vector<Edge> edges;
  open_edges(fans, face[0], edges);
  if (settled) {
    EXPECT_EQ(edges.size(), 2U);
    EXPECT_EQ(fans.around(face[0]), Around::open);
    EXPECT_EQ(fans.fans(face[0]), 1U);
  }
}

/// As a look at every pair of wedges finds them.
std::set<std::pair<std::uint32_t, std::uint32_t>> open_edges_one_by_one(const Fans& fans, std::uint32_t v) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> open;
  const auto wedges = fans.wedges(v);
  for (const Wedge& w : wedges) {
    if (std::ranges::find(wedges, w.first, &Wedge::second) == wedges.end()) open.emplace(w.first, v);
    if (std::ranges::find(wedges, w.second, &Wedge::first) == wedges.end()) open.emplace(v, w.second);
  }
  return open;
}

TEST(Fans, know_the_open_edges_of_a_vertex_of_many_faces_after_any_changes) {
  constexpr std::uint32_t kRing = 60;
  const Fixture f(testing::sphere_points(kRing + 1));
  FaceMasks none = f.faces;
  std::ranges::fill(none, 0U);
  Fans fans(f.stars, std::move(none));
  std::array<bool, kRing> there{};
  std::mt19937 random(6);
  for (int i = 0; i < 3000; ++i) {
    // Now nearly all faces are there, now few.
    const auto k = static_cast<std::uint32_t>(random() % kRing);
    if (there[k] == (random() % 16 < (i / 500 % 2 == 0 ? 15U : 4U))) continue;
    const Face face{kRing, k, (k + 1) % kRing};
    const std::size_t mark = fans.mark();
    there[k] ? fans.remove(face) : fans.add(face);
    if (i % 7 == 0) {
      fans.undo(mark);
    } else {
      there[k] = !there[k];
    }
    std::vector<Edge> edges;
    open_edges(fans, kRing, edges);
    std::set<std::pair<std::uint32_t, std::uint32_t>> open;
    for (const Edge& e : edges) open.emplace(e.from, e.to);
    EXPECT_EQ(open.size(), edges.size());
    ASSERT_EQ(open, open_edges_one_by_one(fans, kRing)) << i;
    const Around around = fans.wedges(kRing).empty() ? Around::nothing : open.empty() ? Around::closed : Around::open;
    ASSERT_EQ(fans.around(kRing), around) << i;
  }
}

TEST(Front, closes_what_was_torn_from_a_sphere_with_the_faces_there_were) {
  const Fixture f(noisy_sphere(2000, 0.002, 5));
  Fans fans(f.stars, f.faces);
  Places places(f.tree, f.stars, {});
  Context context;
  Front front(fans, places);
  for (const Pass& pass : {Pass{0.5, false}, Pass{0, true}}) ASSERT_TRUE(front.advance(pass, context));
  close_holes(fans, places, fans.unsettled(), {30, -0.5});
  ASSERT_EQ(fans.faces(), 2 * 2000U - 4);
  const auto whole = fans.triangles();
  std::mt19937 random(6);
  for (int i = 0; i < 60; ++i) {
    const auto all = fans.triangles();
    const Triangle& t = all[random() % all.size()];
    fans.remove({t[0].value, t[1].value, t[2].value});
  }
  for (const Pass& pass : {Pass{0.5, false}, Pass{0, true}}) ASSERT_TRUE(front.advance(pass, context));
  EXPECT_EQ(fans.triangles(), whole);
}

TEST(Front, never_adds_a_face_that_makes_an_edge_or_a_vertex_non_manifold) {
  for (const double noise : {0.02, 0.1, 0.3}) {
    const Fixture f(noisy_sphere(1200, noise, 7));
    Fans fans(f.stars, f.faces);
    Places places(f.tree, f.stars, {});
    Context context;
    Front front(fans, places);
    for (const Pass& pass : {Pass{0.5, false}, Pass{0, false}, Pass{-0.5, true}}) {
      ASSERT_TRUE(front.advance(pass, context));
      TriangleMesh mesh{f.cloud.positions, fans.triangles(), {}, {}};
      EXPECT_TRUE(topology_of(mesh).edge_manifold);
      EXPECT_TRUE(topology_of(mesh).oriented);
    }
    ASSERT_TRUE(repair_holes(fans, places, 60, context));
    separate_fans(fans);
    insert_leftovers(fans, places);
    TriangleMesh mesh{f.cloud.positions, fans.triangles(), {}, {}};
    EXPECT_TRUE(topology_of(mesh).vertex_manifold);
    EXPECT_TRUE(topology_of(mesh).oriented);
  }
}

TEST(AdoptedMesh, has_the_triangles_it_was_made_of) {
  const auto expect_same = [](TriangleMesh mesh, const std::string& name) {
    AdoptedMesh adopted(mesh, 2);
    sort_triangles(mesh);
    EXPECT_EQ(adopted.fans().triangles(), mesh.triangles) << name;
    EXPECT_EQ(adopted.fans().faces(), mesh.triangles.size()) << name;
  };
  const TriangleMesh sphere = testing::bumpy_sphere(4);
  expect_same(sphere, "closed");
  expect_same(testing::cut_disc(sphere, sphere.positions[5], 0.4).rest, "open, with points that are in no triangle");
  TriangleMesh cone{{{0, 0, 1}}, {}, {}, {}};
  constexpr std::size_t kAround = 3 * LocalStars::kLongestStar;
  for (std::size_t i = 0; i < kAround; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kAround;
    cone.positions.push_back({std::cos(angle), std::sin(angle), 0});
    cone.triangles.push_back(testing::triangle(0, 1 + i, 1 + (i + 1) % kAround));
  }
  expect_same(cone, "a vertex of more triangles than a star holds");
  TriangleMesh touching{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {}, {}, {}};
  touching.triangles = {testing::triangle(0, 1, 2), testing::triangle(0, 3, 4)};
  expect_same(touching, "two fans at a vertex");
}

}  // namespace
}  // namespace surfaced::front
