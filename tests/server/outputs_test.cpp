// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/outputs.hpp"

#include <gtest/gtest.h>

#include "http/accept.hpp"

namespace surfaced::api {
namespace {

std::string chosen(std::string_view accept, const std::vector<std::string>& made = {"mesh.glb"}) {
  const auto mesh = negotiate_mesh(accept, made);
  return mesh ? *mesh : std::string(name_of(mesh.error().code));
}

TEST(NegotiationTest, the_most_wanted_format_is_chosen) {
  EXPECT_EQ(chosen("model/gltf+json"), "mesh.gltf");
  EXPECT_EQ(chosen("model/gltf-binary;q=0.5, model/gltf+json;q=0.9"), "mesh.gltf");
  EXPECT_EQ(chosen("model/*;q=0.1, application/x-draco"), "mesh.drc");
  EXPECT_EQ(chosen("MODEL/PLY, */*;q=0.1"), "mesh.ply");
  EXPECT_EQ(chosen("*/*, model/gltf-binary;q=0"), "mesh.gltf");
}

TEST(NegotiationTest, among_equals_what_is_made_comes_first) {
  EXPECT_EQ(chosen("*/*"), "mesh.glb");
  EXPECT_EQ(chosen("*/*", {"mesh.drc"}), "mesh.drc");
  EXPECT_EQ(chosen("application/octet-stream", {"mesh.glb", "mesh.ply"}), "mesh.ply");
  EXPECT_EQ(negotiate_mesh(std::nullopt, std::vector<std::string>{"mesh.ply"}).value(), "mesh.ply");
}

TEST(NegotiationTest, what_cannot_be_met_is_refused) {
  for (const char* accept : {"image/png", "model/gltf-binary;q=0", "", "nonsense", "model/*;q=7", "*/*;q=0"}) {
    EXPECT_EQ(chosen(accept), "not_acceptable") << accept;
  }
}

TEST(AcceptTest, the_most_specific_range_decides) {
  const auto ranges = http::parse_accept("text/*;q=0.3, text/html;q=0.7;level=1, */*;q=0.5");
  EXPECT_EQ(http::quality_of(ranges, "text/html"), 700);
  EXPECT_EQ(http::quality_of(ranges, "text/plain; charset=utf-8"), 300);
  EXPECT_EQ(http::quality_of(ranges, "image/png"), 500);
}

}  // namespace
}  // namespace surfaced::api
