// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "io/io.hpp"
#include "support/draco_files.hpp"
#include "support/limited_child.hpp"
#include "support/results.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using Bytes = std::vector<std::byte>;

double farthest_nearest(const std::vector<Point3>& from, const std::vector<Point3>& to) {
  double worst = 0;
  for (const Point3& p : from) {
    double best = HUGE_VAL;
    for (const Point3& q : to) best = std::min(best, norm(p - q));
    worst = std::max(worst, best);
  }
  return worst;
}

TEST(DracoReader, reads_every_encoding_that_draco_writes) {
  const TriangleMesh shape = draco_shape();
  const std::vector<DracoFile> files = small_draco_files(shape);
  EXPECT_GT(files.size(), 40U);
  for (const DracoFile& file : files) {
    const auto cloud = parse_cloud(file.bytes, file.name);
    ASSERT_TRUE(cloud.ok()) << file.name << ": " << detail_of(cloud);
    EXPECT_EQ(cloud->size(), shape.positions.size()) << file.name;
    if (file.exact) {
      for (std::size_t i = 0; i < cloud->size(); ++i)
        EXPECT_EQ(cloud->positions[i], shape.positions[i]) << file.name << i;
    }
    // 11 bits over a side of 2.6: half a step per axis.
    EXPECT_LT(farthest_nearest(shape.positions, cloud->positions), 2.6 / 2047 / 2 * std::sqrt(3.0) * 1.01) << file.name;
    EXPECT_EQ(cloud->colors.empty(), !file.name.ends_with("_all")) << file.name;
    EXPECT_EQ(cloud->normals.empty(), !file.name.ends_with("_all")) << file.name;
    if (cloud->source.faces == 0) {
      EXPECT_TRUE(cloud->warnings.empty()) << file.name;
    } else {
      EXPECT_THAT(cloud->warnings, ::testing::ElementsAre(HasSubstr("input=mesh"))) << file.name;
    }
  }
}

TEST(DracoReader, carries_colours_and_normals_unchanged) {
  for (const DracoFile& file : small_draco_files()) {
    if (!file.exact || !file.name.ends_with("_all")) continue;
    const auto cloud = parse_cloud(file.bytes, file.name);
    ASSERT_TRUE(cloud.ok());
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      EXPECT_EQ(cloud->colors[i], (Color4{static_cast<std::uint8_t>(i), 50, 200, 255}));
      EXPECT_EQ(cloud->normals[i], (Normal3{0, 0.6F, i % 2 == 0 ? 0.8F : -0.8F}));
    }
  }
}

TEST(DracoReader, reads_meshes_with_their_topology) {
  const TriangleMesh shape = draco_shape();
  for (const DracoFile& file : small_draco_files(shape)) {
    const auto mesh = decode_mesh(file.bytes, file.name);
    if (!file.mesh) {
      EXPECT_EQ(code_of(mesh), "unsupported_feature") << file.name;
      continue;
    }
    ASSERT_TRUE(mesh.ok()) << file.name << ": " << detail_of(mesh);
    EXPECT_EQ(mesh->triangles.size(), shape.triangles.size());
    if (file.exact) {
      EXPECT_EQ(mesh->triangles, shape.triangles);
    }
    const Topology topology = topology_of(*mesh);
    EXPECT_TRUE(topology.closed) << file.name;
    EXPECT_EQ(topology.genus, 1) << file.name;
  }
}

TEST(DracoHostile, every_truncation_is_refused) {
  for (const DracoFile& file : small_draco_files()) {
    for (std::size_t size = 5; size < file.bytes.size(); ++size) {
      const auto cloud = parse_cloud(std::span(file.bytes).first(size), file.name);
      EXPECT_THAT(code_of(cloud), AnyOf("truncated_input", "malformed_input")) << file.name << " " << size;
    }
  }
}

/// What must hold of any file: a cloud of even arrays, or a refusal that says something; within 2 s.
void expect_sane(const Bytes& bytes, const std::string& what) {
  const auto begin = std::chrono::steady_clock::now();
  const auto cloud = parse_cloud(bytes, "damaged.drc");
  if (cloud) {
    EXPECT_TRUE(cloud->normals.empty() || cloud->normals.size() == cloud->size()) << what;
    EXPECT_TRUE(cloud->colors.empty() || cloud->colors.size() == cloud->size()) << what;
  } else {
    EXPECT_THAT(code_of(cloud), AnyOf("truncated_input", "malformed_input", "unsupported_feature", "missing_positions",
                                      "empty_input", "unknown_format", "too_many_points", "out_of_memory"))
        << what << ": " << detail_of(cloud);
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  if (!measuring_is_moot()) {
    EXPECT_LT(taken.count(), 2) << what;
  }
}

/// What counts and sizes are in is at the beginning; behind it a bit of every byte stands for all (draco_fuzz flips the
/// others, too).
TEST(DracoHostile, every_flipped_bit_of_the_beginning_and_one_of_every_other_byte_is_survived) {
  constexpr std::size_t kBeginning = 48;
  for (const DracoFile& file : small_draco_files()) {
    Bytes bytes = file.bytes;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      if (bit / 8 >= kBeginning && bit % 8 != bit / 8 % 8) continue;
      const auto mask = static_cast<std::byte>(1U << bit % 8);
      bytes[bit / 8] ^= mask;
      expect_sane(bytes, file.name + ", bit " + std::to_string(bit));
      bytes[bit / 8] ^= mask;
    }
  }
}

TEST(DracoHostile, many_changed_bytes_are_survived) {
  std::mt19937 random(11);
  for (const DracoFile& file : small_draco_files()) {
    for (int round = 0; round < 200; ++round) {
      Bytes bytes = file.bytes;
      for (std::size_t changes = 1 + random() % 8; changes > 0; --changes) {
        bytes[random() % bytes.size()] = static_cast<std::byte>(random() & 0xFFU);
      }
      expect_sane(bytes, file.name + ", round " + std::to_string(round));
    }
  }
}

/// A little-endian header and body by hand.
Bytes hand_made(std::uint8_t type, std::uint8_t method, std::uint8_t minor, std::initializer_list<unsigned> body) {
  Bytes bytes;
  for (const unsigned b : {unsigned{'D'}, unsigned{'R'}, unsigned{'A'}, unsigned{'C'}, unsigned{'O'}, 2U,
                           unsigned{minor}, unsigned{type}, unsigned{method}, 0U, 0U}) {
    bytes.push_back(static_cast<std::byte>(b));
  }
  for (const unsigned b : body) bytes.push_back(static_cast<std::byte>(b));
  return bytes;
}

struct Bomb {
  std::string what;
  Bytes bytes;
};

/// Files of a few bytes that ask for gigabytes or hours.
std::vector<Bomb> bombs() {
  // One decoder, one attribute: POSITION (0), float32 (9), 3 components, not normalised, id 0.
  std::vector<Bomb> all;
  all.push_back({"2^31-1 points, sequential", hand_made(0, 0, 3, {0xFF, 0xFF, 0xFF, 0x7F, 1, 1, 0, 9, 3, 0, 0, 2})});
  all.push_back({"2^31-1 points, kd-tree", hand_made(0, 1, 3, {0xFF, 0xFF, 0xFF, 0x7F, 1, 1, 0, 9, 3, 0, 0, 6})});
  all.push_back(
      {"a kd-tree that repeats another count",
       hand_made(0, 1, 3, {10, 0, 0, 0, 1, 1, 0, 9, 3, 0, 0, 6, 11, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0})});
  all.push_back(
      {"2^32-1 triangles, edgebreaker",
       hand_made(1, 1, 2, {0, 0xFF, 0xFF, 0xFF, 0xFF, 3, 0xFF, 0xFF, 0xFF, 0xFF, 4, 0, 0xFF, 0xFF, 0xFF, 0xFF, 4, 0})});
  all.push_back({"2^28 triangles and points, sequential",
                 hand_made(1, 0, 2, {0x80, 0x80, 0x80, 0x80, 1, 0x80, 0x80, 0x80, 0x80, 1, 0})});
  Bytes metadata = hand_made(0, 0, 3, {0, 0});  // no attribute metadata; a block without entries
  metadata[10] = std::byte{0x80};
  for (int i = 0; i < 300; ++i) {  // blocks that each claim as many blocks as bytes are left
    for (const unsigned b : {0xFFU, 0x01U, 0U, 0U}) metadata.push_back(static_cast<std::byte>(b));
  }
  all.push_back({"nested metadata", metadata});
  for (Bomb& bomb : all) bomb.bytes.resize(std::max<std::size_t>(bomb.bytes.size(), 61));
  return all;
}

TEST(DracoHostile, files_of_61_bytes_that_ask_for_gigabytes_are_refused_at_once) {
  for (const Bomb& bomb : bombs()) {
    const auto cloud = parse_cloud(bomb.bytes, "bomb.drc");
    EXPECT_THAT(code_of(cloud), AnyOf("malformed_input", "too_many_points")) << bomb.what;
    const ChildRun run = run_in_child([&] { return parse_cloud(bomb.bytes, "bomb.drc").ok() ? 1 : 0; });
    EXPECT_EQ(run.result, 0) << bomb.what;
    if (measuring_is_moot()) continue;
    EXPECT_LT(run.seconds, 1) << bomb.what;
    EXPECT_LT(run.peak_bytes, std::uint64_t{200} << 20) << bomb.what;
  }
}

TEST(DracoHostile, the_refusal_of_a_lying_count_names_count_and_limit) {
  const auto cloud = parse_cloud(bombs()[0].bytes, "bomb.drc", ReadLimits{.max_points = std::uint64_t{1} << 40});
  EXPECT_EQ(code_of(cloud), "malformed_input");
  EXPECT_THAT(detail_of(cloud), HasSubstr("2147483647 points"));
  EXPECT_THAT(detail_of(cloud), HasSubstr(std::to_string(160 << 20)));
}

TEST(DracoHostile, more_points_than_allowed_are_refused) {
  const DracoFile file = small_draco_files().front();
  const auto cloud = parse_cloud(file.bytes, file.name, ReadLimits{.max_points = 10});
  EXPECT_EQ(code_of(cloud), "too_many_points");
  EXPECT_THAT(detail_of(cloud), HasSubstr("63 points; the limit is 10"));
}

TEST(DracoHostile, versions_and_kinds_that_are_not_known_are_refused_by_name) {
  Bytes bytes = small_draco_files().front().bytes;
  bytes[5] = std::byte{3};
  EXPECT_THAT(detail_of(parse_cloud(bytes, "a.drc")), HasSubstr("3.3"));
  bytes[5] = std::byte{2};
  bytes[7] = std::byte{2};
  EXPECT_EQ(code_of(parse_cloud(bytes, "a.drc")), "unsupported_feature");
}

class SharedDraco : public ::testing::TestWithParam<const char*> {
 protected:
  static Bytes load(const std::string& name) {
    std::ifstream file(std::string(SURFACED_SHARED_DATA) + "/" + name, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto span = std::as_bytes(std::span(text));
    return {span.begin(), span.end()};
  }
};

TEST_P(SharedDraco, survives_cuts_and_flipped_bits_all_over) {
  Bytes bytes = load(GetParam());
  if (bytes.empty()) GTEST_SKIP() << GetParam() << " is not there";
  ASSERT_EQ(code_of(parse_cloud(bytes, GetParam())), "ok");
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    const std::size_t size = random() % bytes.size();
    EXPECT_NE(code_of(parse_cloud(std::span(bytes).first(size), GetParam())), "ok") << size;
  }
  for (int round = 0; round < 1500; ++round) {
    // Half of the flips fall on the first bytes, where counts and types are.
    const std::size_t at = round % 2 == 0 ? random() % 64 : random() % bytes.size();
    const auto mask = static_cast<std::byte>(1U << random() % 8);
    bytes[at] ^= mask;
    expect_sane(bytes, std::string(GetParam()) + ", byte " + std::to_string(at));
    bytes[at] ^= mask;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, SharedDraco,
                         ::testing::Values("heart_seq.drc", "fertility_kd.drc", "pc_color.drc", "pc_kd_color.drc"));

TEST(SharedDracoPair, both_encodings_of_the_patch_hold_the_same_points) {
  const std::string folder = SURFACED_SHARED_DATA;
  if (!std::filesystem::exists(folder + "/pc_color.drc")) GTEST_SKIP() << "./dev data fetches it";
  const auto sequential = read_cloud(folder + "/pc_color.drc");
  const auto kd = read_cloud(folder + "/pc_kd_color.drc");
  ASSERT_TRUE(sequential.ok() && kd.ok());
  EXPECT_EQ(sequential->size(), 7733U);
  EXPECT_EQ(kd->size(), 7733U);
  EXPECT_EQ(sequential->colors.size(), 7733U);
  EXPECT_EQ(kd->colors.size(), 7733U);
}

}  // namespace
}  // namespace surfaced
