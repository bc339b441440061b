// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are no clouds are named for what they are, and what may be a cloud is not taken for one of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "io/io.hpp"
#include "support/results.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using namespace std::string_literals;
using ::testing::HasSubstr;
using Named = std::vector<std::pair<std::string, std::string>>;

void expect_named(const Named& files) {
  for (const auto& [text, word] : files) {
    const auto cloud = parse_text(text);
    EXPECT_EQ(code_of(cloud), "unknown_format") << word;
    EXPECT_THAT(detail_of(cloud), HasSubstr(word));
    EXPECT_EQ(code_of(decode_mesh(as_bytes(text), "mesh")), "unknown_format") << word;
  }
}

TEST(FilesThatAreNoClouds, are_named_if_they_are_binary) {
  const std::string rest(64, '\0');
  expect_named({{"II+\0"s + rest, "picture"},
                {"CDF\x01"s + rest, "NetCDF"},
                {" BDV"s + rest, "OpenVDB"},
                {"ARROW1\0\0"s + rest, "Arrow"},
                {"\x80\x04\x95\x10" + rest, "pickle"},
                {"\x0a\x0d\x0d\x0a\x1c" + rest, "network packets"},
                {"\0\0\x27\x0a"s + rest, "shapefile"},
                {"MMd\x05\0\0\x02\0"s + rest, "3ds Max"},
                {"FORM\0\0\1\0LWO2"s + rest, "LightWave"},
                {"FORM\0"s, "begins with"},
                {"OCTM\5"s + rest, "OpenCTM"},
                {"CCB2"s + rest, "CloudCompare"},
                {"GRIB"s + rest, "GRIB"},
                {"P5\n4 4\n255\n"s + rest, "picture"},
                {"\x04\x22\x4d\x18"s + rest, "archive"}});
}

TEST(FilesThatAreNoClouds, are_named_if_they_are_text) {
  const std::string iges = "IGES file generated from a drawing" + std::string(38, ' ') + "S      1\n";
  expect_named({{"<head><title>502 Bad Gateway</title></head>\n", "web page"},
                {"<!-- made -->\n<html></html>", "web page"},
                {"<soap:Envelope><soap:Body></soap:Body></soap:Envelope>", "XML"},
                {"{\"x\": 1, \"y\": 2}\n{\"x\": 3, \"y\": 4}\n", "JSON"},
                {"P2\n8 8\n255\n1 2 3 4\n5 6 7 8\n", "picture"},
                {iges + iges, "IGES"},
                {"# Blender MTL File\nnewmtl stone\nKd 1 1 1\n", "materials"},
                {"$MeshFormat\n4.1 0 8\n", "Gmsh"}});
}

TEST(FilesThatAreNoClouds, are_told_by_a_rotation_of_unit_length_in_every_record) {
  std::string splat;
  for (int i = 0; i < 20; ++i) {
    for (const float x : {1.5F, static_cast<float>(i), -3.F, 0.01F, 0.01F, 0.02F}) {
      splat.append(reinterpret_cast<const char*>(&x), sizeof x);
    }
    splat += "\x40\x41\x42\xff\xff\x80\x80\x80";
  }
  expect_named({{splat, ".splat of Gaussians"}});
  splat[31] = '\x40';
  EXPECT_THAT(detail_of(parse_text(splat)), HasSubstr("begins with"));
}

TEST(FilesThatAreNoClouds, are_not_such_as_begin_with_the_label_of_a_point) {
  EXPECT_EQ(read("P2 1 2 3\nP5 4 5 6\n").size(), 2U);
  EXPECT_EQ(read("MM 1 2 3\nMZ 4 5 6\n").size(), 2U);
  EXPECT_EQ(read("<X> <Y> <Z>\n1 2 3\n4 5 6\n").size(), 2U);
  // The names of sections in an INI are no JSON.
  EXPECT_THAT(detail_of(parse_text("[scan]\nname = room\n")), HasSubstr("is text"));
}

}  // namespace
}  // namespace surfaced
