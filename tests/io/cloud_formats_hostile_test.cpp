// SPDX-License-Identifier: GPL-3.0-or-later
// Damaged and lying files of the formats of other programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/io.hpp"
#include "support/hostile_files.hpp"
#include "support/scan_files.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::AnyOf;

std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string with_byte(std::string text, std::size_t at, char value) {
  text.at(at) = value;
  return text;
}

std::vector<Refused> refused_texts() {
  return {
      {"words", "hello, this is no cloud\n", "unknown_format", "hello"},
      {"a comment alone", "# nothing here\n", "unknown_format", "nothing"},
      {"a gzip that ends early", "\x1f\x8b\x08", "truncated_input", "18 bytes"},
      {"an E57", "ASTM-E57 and more", "unknown_format", "E57"},
      {"two columns", "1 2\n", "unknown_format", "1 2"},
      {"a short row", "1 2 3\n4 5\n", "malformed_input", "line 2: 2 values; the first row has 3"},
      {"a long row", "1 2 3\n4 5 6 7\n", "malformed_input", "line 2"},
      {"letters in a row", "1 2 3\n4 b 6\n", "malformed_input", "column 2: 'b'"},
      {"a header alone", "x,y,z\n", "empty_input", "no points"},
      {"a line of a megabyte", "1 2 3\n" + std::string(1000000, '1'), "malformed_input", "65536"},
      {"a PTS of 10^15 points", "1000000000000000\n1 2 3\n", "truncated_input", "1000000000000000"},
      {"a PTS with a point too few", "3\n10 20 30\n40 50 60\n\n\n\n\n\n\n", "truncated_input", "2 of 3"},
      {"a PTX", "2\n1\n0 0 0\n1 0 0\n0 1 0\n", "unsupported_feature", "PTX"},
      {"an OBJ with two coordinates", "v 1 2\n", "malformed_input", "line 1: 2 values"},
      {"an OBJ of letters", "v 1 2 3\nv a b c\n", "malformed_input", "'a'"},
      {"an OBJ with something else", "v 1 2 3\nDear Sir\n", "malformed_input", "'Dear'"},
      {"an OBJ without vertices", "o nothing\ng nobody\n", "empty_input", "no vertices"},
  };
}

std::vector<Refused> refused_binaries() {
  const std::vector<LasPoint> points(3);
  const LasOptions huge{.minor = 4, .format = 6, .declared = 10'000'000'000};
  return {
      {"a LAS of ten billion points", las_file(points, huge), "too_many_points", "10000000000 points"},
      {"a LAS with a point too many", las_file(points, {.declared = 4}), "truncated_input", "4 points, 3 are there"},
      {"a LAS without points", las_file({}), "empty_input", "0 points"},
      {"a LAZ", with_byte(las_file(points), 104, static_cast<char>(0x82)), "unsupported_feature", "laszip"},
      {"a LAS of format 11", with_byte(las_file(points), 104, 11), "unsupported_feature", "point format 11"},
      {"a LAS 2.0", with_byte(las_file(points), 24, 2), "unsupported_feature", "version 2.2"},
      {"a LAS with short records", with_byte(las_file(points), 105, 5), "malformed_input", "5 bytes"},
      {"a LAS of scale 0", las_file(points, {.scale = {1, 0, 1}}), "malformed_input", "scale of y"},
      {"a LAS of infinite offset", las_file(points, {.offset = {1, 2, 1 / 0.0}}), "malformed_input", "scale of z"},
      {"a LAS that begins in its header", with_byte(las_file(points), 96, 9), "malformed_input", "byte 9"},
      {"a LAS cut in its header", las_file(points).substr(0, 100), "truncated_input", "227"},
      {"an STL with more facets than bytes",
       changed(binary_stl(two_facets(), "solid x"), "solid x", "solid y").substr(0, 150), "truncated_input",
       "2 facets, 1"},
      {"an STL without facets", binary_stl({}), "empty_input", "no facets"},
      {"an ascii STL that ends early", changed(ascii_stl(two_facets()), "endsolid", "# solid"), "malformed_input",
       "'#'"},
      {"an ascii STL with two corners", changed(ascii_stl(two_facets()), "    vertex 1", "#"), "malformed_input",
       "begins with '#."},
      {"an ascii STL with four corners", changed(ascii_stl(two_facets()), "endloop", "vertex 1 1 1"), "malformed_input",
       "more than 3"},
      {"a PCD of 10^15 points",
       changed(changed(pcd_binary(), "POINTS 2", "POINTS 1000000000000000"), "WIDTH 2", "WIDTH 9"), "too_many_points",
       "1000000000000000"},
      {"a PCD with a point too many", changed(pcd_binary(), "POINTS 2", "POINTS 3"), "truncated_input", "3 points"},
      {"an ascii PCD with a point too many", changed(pcd_ascii(), "POINTS 3", "POINTS 4"), "truncated_input",
       "3 are there"},
      {"a PCD without DATA", changed(pcd_ascii(), "DATA", "# AT"), "malformed_input", "'1.5'"},
      {"a PCD without x", changed(pcd_ascii(), "FIELDS x", "FIELDS u"), "missing_positions", "'y'"},
      {"a PCD with another size", changed(pcd_ascii(), "SIZE 4", "SIZE 3"), "malformed_input", "'3'"},
      {"a PCD with another type", changed(pcd_ascii(), "TYPE F", "TYPE Q"), "malformed_input", "'Q'"},
      {"a PCD with a million values", changed(pcd_ascii(), "1 3\nWIDTH", "1 1000000\nWIDTH"), "malformed_input",
       "1000000"},
      {"a PCD of other data", changed(pcd_ascii(), "DATA ascii", "DATA morse"), "malformed_input", "morse"},
      {"a PCD of words", changed(pcd_ascii(), "1.5", "one"), "malformed_input", "'one'"},
      {"a PCD with a long row", changed(pcd_ascii(), "1 2 3\n", "1 2 3 4\n"), "malformed_input", "more values"},
      {"a PCD of sixes", changed(pcd_ascii(), "WIDTH 3", "WIDTH -6"), "malformed_input", "-6"},
      {"a compressed PCD of damage", with_byte(pcd_compressed(), pcd_compressed().size() - 2, '\x7f'),
       "malformed_input", "damaged"},
      {"a compressed PCD of other sizes", changed(pcd_compressed(), "POINTS 2", "POINTS 1"), "malformed_input", "35"},
  };
}

TEST(CloudFormatsHostile, every_kind_of_bad_file_is_refused_with_its_code_and_the_reason) {
  expect_refused(refused_texts());
  expect_refused(refused_binaries());
}

TEST(CloudFormatsHostile,
     a_las_of_ten_billion_points_is_refused_before_anything_is_allocated_even_where_they_are_allowed) {
  const std::string text = las_file(std::vector<LasPoint>(3), {.minor = 4, .format = 6, .declared = 4'000'000'000});
  EXPECT_EQ(code_of(parse_text(text, {.max_points = 20'000'000'000})), "truncated_input");
}

TEST(CloudFormatsHostile, more_points_than_allowed_are_refused) {
  for (const std::string& text :
       {las_file(std::vector<LasPoint>(3)), pcd_ascii(), pcd_binary(), ascii_stl(two_facets()),
        binary_stl(two_facets()), std::string(kObj), std::string("1 2 3\n4 5 6\n7 8 9\n")}) {
    EXPECT_EQ(code_of(parse_text(text, {.max_points = 1})), "too_many_points") << text.substr(0, 40);
  }
}

std::vector<std::string> binary_files() {
  return {las_file(std::vector<LasPoint>(3)), las_file(std::vector<LasPoint>(2), {.minor = 4, .format = 7}),
          pcd_binary(), pcd_compressed(), binary_stl(two_facets())};
}

TEST(CloudFormatsHostile, every_truncation_of_a_binary_file_is_refused) {
  for (const std::string& text : binary_files()) {
    for (std::size_t size = 0; size < text.size(); ++size) {
      const auto cloud = parse_text(std::string_view(text).substr(0, size));
      EXPECT_THAT(code_of(cloud),
                  AnyOf("truncated_input", "unknown_format", "empty_input", "malformed_input", "missing_positions"))
          << size << " of " << text.size() << ": " << text.substr(0, 20);
    }
  }
}

TEST(CloudFormatsHostile, every_flipped_bit_is_survived) {
  std::vector<std::string> files = binary_files();
  for (const auto& [name, text] : text_clouds()) files.push_back(text);
  for (const std::string& text : {pcd_ascii(), ascii_stl(two_facets()), std::string(kObj)}) files.push_back(text);
  for (std::string& text : files) {
    for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
      const auto flip = [&] { text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8); };
      flip();
      const auto cloud = parse_text(text);
      EXPECT_NE(code_of(cloud), "internal_error") << bit << ": " << detail_of(cloud);
      if (cloud) {
        EXPECT_GT(cloud->size(), 0U);
        EXPECT_TRUE(cloud->normals.empty() || cloud->normals.size() == cloud->size());
        EXPECT_TRUE(cloud->colors.empty() || cloud->colors.size() == cloud->size());
      }
      EXPECT_NE(code_of(decode_mesh(testing::as_bytes(text), "mesh")), "internal_error");
      flip();
    }
  }
}

TEST(MeshFormatsHostile, every_truncation_and_flipped_bit_of_a_3mf_is_survived) {
  std::vector<std::byte> bytes = encode_mesh(tetrahedron(), MeshFormat::threemf).value();
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    EXPECT_NE(code_of(decode_mesh(std::span(bytes).first(size), "cut.3mf")), "ok") << size;
  }
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    EXPECT_NE(code_of(decode_mesh(bytes, "flipped.3mf")), "internal_error") << bit;
    bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
  }
}

std::string repeated(const std::string& text, std::size_t bytes) {
  std::string result;
  while (result.size() < bytes) result += text;
  return result;
}

TEST(CloudFormatsHostile, a_million_bytes_of_anything_take_less_than_two_seconds_and_200_megabytes) {
  if (measuring_is_moot()) GTEST_SKIP() << "sanitizers change time and memory";
  ByteWriter bomb;  // 264 zeros in every three bytes
  const std::string packed = std::string("\x00\x00", 2) + repeated(std::string("\xe0\xff\x00", 3), 999'990);
  const auto unpacked = static_cast<std::uint32_t>(1 + (packed.size() - 2) / 3 * 264);
  bomb.put_text("VERSION .7\nFIELDS x y z\nSIZE 1 1 1\nTYPE U U U\nWIDTH " + std::to_string(unpacked / 3) +
                "\nHEIGHT 1\nDATA binary_compressed\n");
  bomb.put(static_cast<std::uint32_t>(packed.size())).put(unpacked / 3 * 3).put_text(packed);
  const std::vector<std::string> files{
      repeated("0 0 0\n", 1000000),
      repeated("0 0 0 1 1 1 0 0 1\n", 1000000),
      repeated("v 0 0 0\n", 1000000),
      repeated("v 0 0 0\n", 500000) + "f " + repeated("f 1 2 3 4 5 6 7 8 9\n", 500000),
      "v 0 0 0\n" + repeated("vn 0 0 0\n", 1000000),
      repeated("solid\n", 1000000),
      "solid\n" + repeated("facet\n", 1000000),
      "1\n0 0 0\n" + repeated("0\n", 1000000),
      "VERSION .7\n" + repeated("FIELDS x y z x y z x y z\n", 1000000),
      repeated("#\n", 1000000),
      repeated("\n", 1000000),
      repeated("1,", 60000),
      las_file(std::vector<LasPoint>(30000)),
      bomb.text,
  };
  expect_cheap(files);
}

}  // namespace
}  // namespace surfaced
