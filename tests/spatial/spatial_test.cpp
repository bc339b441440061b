// SPDX-License-Identifier: GPL-3.0-or-later
#include "spatial/spatial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/nasty_clouds.hpp"

namespace surfaced {
namespace {

std::vector<std::uint32_t> indices(const Neighbours& n) {
  return {n.index.begin(), n.index.begin() + static_cast<std::ptrdiff_t>(n.count)};
}

/// The k nearest by (squared distance as float, index), ascending by index.
std::vector<std::uint32_t> slow_nearest(const BoxTree& tree, std::size_t v, std::size_t k) {
  std::vector<std::pair<float, std::uint32_t>> all;
  for (std::size_t w = 0; w < tree.points(); ++w) {
    const Point3 d = tree.local(w) - tree.local(v);
    if (w != v)
      all.emplace_back(static_cast<float>(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), static_cast<std::uint32_t>(w));
  }
  std::ranges::sort(all);
  all.resize(std::min(k, all.size()));
  std::vector<std::uint32_t> list;
  for (const auto& entry : all) list.push_back(entry.second);
  std::ranges::sort(list);
  return list;
}

void expect_exact(const std::vector<Point3>& points, std::size_t k) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  const BoxTree tree(cloud.positions, 1);
  NeighbourSearch search(tree);
  NeighbourSearch anywhere(tree);
  Neighbours found;
  for (std::size_t leaf = 0; leaf < tree.leaves(); ++leaf) {
    search.begin_leaf(leaf, k);
    for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
      const auto expected = slow_nearest(tree, v, k);
      search.nearest(v, k, found);
      ASSERT_EQ(indices(found), expected);
      anywhere.nearest_anywhere(v, k, found);
      ASSERT_EQ(indices(found), expected);
      search.gathered(v, found);
      for (const std::uint32_t w : expected) ASSERT_TRUE(std::ranges::binary_search(indices(found), w));
    }
  }
}

TEST(NeighbourSearch, agrees_with_brute_force_on_surfaces_and_in_space) {
  for (const std::size_t k : {1U, 5U, 16U, 48U}) {
    expect_exact(testing::sphere_points(1500), k);
    expect_exact(testing::torus_points(60, 20), k);
    expect_exact(testing::random_points(1300, 7), k);
  }
}

TEST(NeighbourSearch, agrees_with_brute_force_where_distances_tie_and_scales_differ) {
  for (std::uint64_t number = 0; number < 600; ++number) {
    const auto points = testing::NastyClouds::make(number).points;
    expect_exact(points, 8);
    expect_exact(points, 16);
  }
}

TEST(NeighbourSearch, gathers_every_point_within_the_radius_it_claims) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::random_points(2000, 3)));
  const BoxTree tree(cloud.positions, 1);
  NeighbourSearch search(tree);
  Neighbours found;
  for (std::size_t leaf = 0; leaf < tree.leaves(); ++leaf) {
    search.begin_leaf(leaf, 16);
    for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
      search.nearest(v, 16, found);
      search.gathered(v, found);
      std::size_t within = 0;
      for (std::size_t w = 0; w < tree.points(); ++w) {
        const Point3 d = tree.local(w) - tree.local(v);
        if (w != v && static_cast<double>(static_cast<float>(dot(d, d))) <= found.covered2) ++within;
      }
      ASSERT_EQ(found.count, within);
    }
  }
}

TEST(BoxTree, leaves_cover_every_point_once_and_stay_within_blocks) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::torus_points(120, 40)));
  for (const unsigned threads : {1U, 3U}) {
    const BoxTree tree(cloud.positions, threads);
    std::size_t next = 0;
    for (std::size_t block = 0; block < tree.blocks(); ++block) {
      EXPECT_EQ(tree.first_point(tree.first_leaf(block)), block * BoxTree::kPointsPerBlock);
      for (std::size_t leaf = tree.first_leaf(block); leaf < tree.first_leaf(block + 1); ++leaf) {
        EXPECT_EQ(tree.first_point(leaf), next);
        next = tree.first_point(leaf + 1);
        EXPECT_LE(next - tree.first_point(leaf), BoxTree::kLargestLeaf);
      }
    }
    EXPECT_EQ(next, cloud.size());
  }
}

TEST(BoxTree, finds_no_leaf_in_an_empty_cloud_and_one_in_a_cloud_of_one_point) {
  const BoxTree none(std::span<const Point3>{}, 1);
  EXPECT_EQ(none.leaves(), 0U);
  const std::vector<Point3> one{{3, 4, 5}};
  const BoxTree tree(one, 1);
  NeighbourSearch search(tree);
  search.begin_leaf(0, 16);
  Neighbours found;
  search.nearest(0, 16, found);
  EXPECT_EQ(found.count, 0U);
}

}  // namespace
}  // namespace surfaced
