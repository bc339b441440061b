// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/io.hpp"
#include "support/hostile_files.hpp"
#include "support/ply_files.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::HasSubstr;

constexpr std::string_view kThreeAxes = "property float x\nproperty float y\nproperty float z\n";

std::string with_vertices(const std::string& count, const std::string& form = "binary_little_endian") {
  return "ply\nformat " + form + " 1.0\nelement vertex " + count + "\n" + std::string(kThreeAxes) + "end_header\n";
}

std::vector<Refused> refused_files() {
  const std::string ten = std::string(120, '\0');
  const std::string start = "ply\nformat ascii 1.0\n";
  return {
      {"an empty file", "", "empty_input", "0 bytes"},
      {"a PNG", "\x89PNG\r\n\x1a\n lots of pixels", "unknown_format", "picture"},
      {"text", "Dear Sir or Madam,\n", "unknown_format", "Dear Sir"},
      {"three letters", "ply", "unknown_format", "'ply'"},
      {"a header cut off", "ply\nformat ascii 1.0\nelement vert", "truncated_input", "line 2"},
      {"2^40 points", with_vertices("1099511627776") + ten, "truncated_input", "1099511627776"},
      {"2^64 points", with_vertices("18446744073709551616") + ten, "truncated_input", "120 bytes follow"},
      {"one point too many", with_vertices("11") + ten, "truncated_input", "10 of 11"},
      {"2^40 points in ascii", with_vertices("1099511627776", "ascii") + "1 2 3\n", "truncated_input", "1099511627776"},
      {"a missing ascii row", with_vertices("2", "ascii") + "1.0 2.0 3.0\n", "truncated_input", "1 of 2"},
      {"a cut ascii row", with_vertices("2", "ascii") + "1.0 2.0 3.0\n4 5", "truncated_input", "1 of 2"},
      {"a short ascii row", with_vertices("2", "ascii") + "1.0 2.0\n4.0 5.0 6.0\n", "malformed_input", "row 1 of 2"},
      {"a long ascii row", with_vertices("2", "ascii") + "1 2 3 4\n4 5 6\n", "malformed_input", "more values"},
      {"no points", with_vertices("0"), "empty_input", "0 vertices"},
      {"a negative count", with_vertices("-5"), "malformed_input", "'-5'"},
      {"a count of letters", with_vertices("ten"), "malformed_input", "'ten'"},
      {"no format", "ply\nelement vertex 1\nend_header\n", "malformed_input", "format"},
      {"an unknown format", "ply\nformat binary_middle_endian 1.0\nend_header\n", "malformed_input", "middle"},
      {"another version", "ply\nformat ascii 2.0\nend_header\n", "unsupported_feature", "2.0"},
      {"two formats", start + "format ascii 1.0\nend_header\n", "malformed_input", "second"},
      {"an unknown keyword", start + "elephant vertex 1\nend_header\n", "malformed_input", "elephant"},
      {"an unknown type", start + "element vertex 1\nproperty quad x\nend_header\n", "malformed_input", "quad"},
      {"a property too early", start + "property float x\nend_header\n", "malformed_input", "line 3"},
      {"a nameless property", start + "element vertex 1\nproperty float\nend_header\n", "malformed_input", "name"},
      {"a list counted by floats", start + "element vertex 1\nproperty list float int x\nend_header\n",
       "malformed_input", "integer"},
      {"a property twice",
       start + "element vertex 1\n" + std::string(kThreeAxes) + "property int x\nend_header\n1 1 1 1\n",
       "malformed_input", "twice"},
      {"an element twice", start + "element vertex 1\nelement vertex 2\nend_header\n", "malformed_input", "twice"},
      {"no vertices", start + "element points 1\n" + std::string(kThreeAxes) + "end_header\n1 1 1\n",
       "missing_positions", "'vertex'"},
      {"no z", start + "element vertex 1\nproperty float x\nproperty float y\nend_header\n1 1\n", "missing_positions",
       "'x', 'y'"},
      {"x as a list",
       start +
           "element vertex 1\nproperty list uchar float x\nproperty float y\nproperty float z\nend_header\n1 1 1 1\n",
       "missing_positions", "(list)"},
      {"a list beyond the file",
       "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint int i\nelement vertex 1\n" +
           std::string(kThreeAxes) + "end_header\n" + std::string(4, '\xff') + ten,
       "truncated_input", "'face'"},
      {"a list of -1 values",
       "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int int i\nelement vertex 1\n" +
           std::string(kThreeAxes) + "end_header\n" + std::string(4, '\xff') + ten,
       "malformed_input", "-1"},
      {"2^40 faces after the points",
       "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + std::string(kThreeAxes) +
           "element face 1099511627776\nproperty list uchar int i\nend_header\n" + ten,
       "truncated_input", "'face'"},
      {"2^40 empty lists in ascii",
       start + "element face 1099511627776\nproperty list uchar int i\nelement vertex 1\n" + std::string(kThreeAxes) +
           "end_header\n0\n0\n0\n",
       "truncated_input", "'face'"},
  };
}

TEST(PlyHostile, every_kind_of_bad_file_is_refused_with_its_code_and_the_reason) { expect_refused(refused_files()); }

TEST(PlyHostile, a_header_without_end_is_refused_at_its_limit) {
  std::string text = "ply\nformat ascii 1.0\n";
  while (text.size() < (std::size_t{2} << 20)) text += "comment all work and no play\n";
  const auto cloud = parse_text(text);
  EXPECT_EQ(code_of(cloud), "malformed_input");
  EXPECT_THAT(detail_of(cloud), HasSubstr("1048576"));
  EXPECT_EQ(code_of(parse_text("ply\n" + std::string(std::size_t{2} << 20, 'x'))), "malformed_input");
}

TEST(PlyHostile, more_points_than_allowed_are_refused_before_they_are_read) {
  const auto cloud = parse_text(with_vertices("10") + std::string(120, '\0'), {.max_points = 9});
  EXPECT_EQ(code_of(cloud), "too_many_points");
  EXPECT_THAT(detail_of(cloud), HasSubstr("10 points; the limit is 9"));
}

TEST(PlyHostile, every_truncation_of_a_file_is_refused) {
  for (const PlyForm form : {PlyForm::ascii, PlyForm::little, PlyForm::big}) {
    PlyBuilder ply(form);
    ply.element("vertex", 3)
        .property("float", "x")
        .property("float", "y")
        .list("uchar", "int", "l")
        .property("float", "z");
    ply.element("face", 1).list("uchar", "int", "vertex_indices");
    for (int i = 0; i < 3; ++i) {
      ply.value("float", i).value("float", 10 + i).list_value("uchar", "int", {1, 2}).value("float", 20 + i).end_row();
    }
    ply.list_value("uchar", "int", {0, 1, 2}).end_row();
    const std::string text = ply.text();
    ASSERT_EQ(code_of(parse_text(text)), "ok");
    // The end of an ascii file may lack its blank and its line end; the cut before them cuts a number.
    const std::size_t needed = form == PlyForm::ascii ? text.size() - 2 : text.size();
    for (std::size_t size = 5; size < needed; ++size) {
      const auto cloud = parse_text(std::string_view(text).substr(0, size));
      EXPECT_EQ(code_of(cloud), "truncated_input") << size << " of " << text.size() << ": " << detail_of(cloud);
    }
  }
}

TEST(PlyHostile, a_million_bytes_of_anything_take_less_than_two_seconds_and_200_megabytes) {
  if (measuring_is_moot()) GTEST_SKIP() << "sanitizers change time and memory";
  const std::string zeros(1000000, '\0');
  std::string digits;
  while (digits.size() < 1000000) digits += "0 ";
  std::string properties;
  while (properties.size() < 1000000) properties += "property char p" + std::to_string(properties.size()) + "\n";
  std::string elements;
  while (elements.size() < 1000000) elements += "element e" + std::to_string(elements.size()) + " 1099511627776\n";
  const std::string three_chars = "property uchar x\nproperty uchar y\nproperty uchar z\n";
  const std::vector<std::string> files{
      with_vertices("83333") + zeros,
      "ply\nformat binary_little_endian 1.0\nelement vertex 333333\n" + three_chars + "end_header\n" + zeros,
      "ply\nformat binary_big_endian 1.0\nelement face 1000000\nproperty list uchar int i\nelement vertex 1\n" +
          three_chars + "end_header\n" + zeros + "abc",
      with_vertices("166666", "ascii") + digits,
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uint int i\n" + three_chars + "end_header\n4294967295 " +
          digits,
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + properties + "end_header\n",
      "ply\nformat binary_little_endian 1.0\n" + elements + "element vertex 1\n" + three_chars + "end_header\nabc",
      "ply\nformat ascii 1.0\n" + zeros,
      "ply\n" + std::string(1000000, '\n'),
      with_vertices("1", "ascii") + std::string(1000000, ' '),
  };
  expect_cheap(files);
}

}  // namespace
}  // namespace surfaced
