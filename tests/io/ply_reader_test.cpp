// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <limits>

#include "io/io.hpp"
#include "support/ply_files.hpp"
#include "support/results.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::array kForms{PlyForm::ascii, PlyForm::little, PlyForm::big};

struct TypeCase {
  std::string name;
  std::vector<double> values;
};

/// Both spellings of every type, with its ends.
std::vector<TypeCase> type_cases() {
  const double float_max = std::numeric_limits<float>::max();
  const double float_least = std::numeric_limits<float>::denorm_min();
  const double double_max = std::numeric_limits<double>::max();
  const double double_least = std::numeric_limits<double>::denorm_min();
  std::vector<TypeCase> cases;
  for (const char* name : {"char", "int8"}) cases.push_back({name, {-128, 127, -1}});
  for (const char* name : {"uchar", "uint8"}) cases.push_back({name, {0, 255, 17}});
  for (const char* name : {"short", "int16"}) cases.push_back({name, {-32768, 32767, -2}});
  for (const char* name : {"ushort", "uint16"}) cases.push_back({name, {0, 65535, 258}});
  for (const char* name : {"int", "int32"}) cases.push_back({name, {-2147483648.0, 2147483647.0, 16909060}});
  for (const char* name : {"uint", "uint32"}) cases.push_back({name, {0, 4294967295.0, 16909060}});
  for (const char* name : {"float", "float32"})
    cases.push_back({name, {-float_max, float_least, static_cast<double>(0.1F)}});
  for (const char* name : {"double", "float64"}) cases.push_back({name, {-double_max, double_least, 0.1}});
  return cases;
}

TEST(PlyReader, reads_every_scalar_type_in_every_form_bit_for_bit) {
  for (const TypeCase& type : type_cases()) {
    for (const PlyForm form : kForms) {
      PlyBuilder ply(form);
      ply.element("vertex", 1);
      for (const char* axis : {"x", "y", "z"}) ply.property(type.name, axis);
      for (const double v : type.values) ply.value(type.name, v);
      const auto cloud = parse_text(ply.text());
      ASSERT_TRUE(cloud.ok()) << type.name << ": " << detail_of(cloud);
      EXPECT_THAT(cloud->positions[0], ElementsAre(type.values[0], type.values[1], type.values[2])) << type.name;
    }
  }
}

TEST(PlyReader, takes_properties_in_any_order_with_elements_and_lists_around_them) {
  for (const PlyForm form : kForms) {
    PlyBuilder ply(form);
    ply.element("camera", 2).property("float", "fov").list("uchar", "int", "pixels");
    ply.element("vertex", 2).property("short", "z").list("uchar", "int", "before").property("double", "x");
    ply.property("float", "quality").property("float", "y").list("uchar", "int", "after");
    ply.element("face", 1).list("uchar", "int", "vertex_indices");
    ply.value("float", 1).list_value("uchar", "int", {5, 6, 7}).end_row();
    ply.value("float", 2).list_value("uchar", "int", {}).end_row();
    ply.value("short", 3).list_value("uchar", "int", {9}).value("double", 1).value("float", 8).value("float", 2);
    ply.list_value("uchar", "int", {}).end_row();
    ply.value("short", 6).list_value("uchar", "int", {}).value("double", 4).value("float", 8).value("float", 5);
    ply.list_value("uchar", "int", {1, 2}).end_row();
    ply.list_value("uchar", "int", {0, 1, 0}).end_row();
    const auto cloud = parse_text(ply.text());
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    EXPECT_THAT(cloud->positions, ElementsAre(Point3{1, 2, 3}, Point3{4, 5, 6}));
  }
}

TEST(PlyReader, carries_normals_and_byte_colours_unchanged) {
  for (const PlyForm form : kForms) {
    PlyBuilder ply(form);
    ply.element("vertex", 1)
        .property("uchar", "red")
        .property("float", "nz")
        .property("float", "x")
        .property("float", "y");
    ply.property("float", "z").property("uchar", "alpha").property("uchar", "blue").property("uchar", "green");
    ply.property("float", "nx").property("float", "ny");
    for (const auto& [type, v] : std::vector<std::pair<const char*, double>>{{"uchar", 1},
                                                                             {"float", 0.25},
                                                                             {"float", 1},
                                                                             {"float", 2},
                                                                             {"float", 3},
                                                                             {"uchar", 4},
                                                                             {"uchar", 3},
                                                                             {"uchar", 2},
                                                                             {"float", 0.75},
                                                                             {"float", 0.5}}) {
      ply.value(type, v);
    }
    const auto cloud = parse_text(ply.text());
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    EXPECT_THAT(cloud->normals, ElementsAre(Normal3{0.75F, 0.5F, 0.25F}));
    EXPECT_THAT(cloud->colors, ElementsAre(Color4{1, 2, 3, 4}));
  }
}

struct ColourCase {
  std::string type;
  std::vector<double> values;
  std::vector<int> expected;
};

TEST(PlyReader, scales_other_colours_by_the_largest_of_them) {
  const std::vector<ColourCase> cases{{"float", {0, 0.5, 1}, {0, 128, 255}},
                                      {"float", {0, 127, 255}, {0, 127, 255}},
                                      {"double", {1, 1, 1}, {255, 255, 255}},
                                      {"ushort", {0, 257, 65535}, {0, 1, 255}},
                                      {"ushort", {1, 2, 255}, {1, 2, 255}},
                                      {"int", {0, 12, 200}, {0, 12, 200}},
                                      {"uint", {0, 2147483648.0, 4294967295.0}, {0, 128, 255}},
                                      {"float", {-1, 0.5, 1}, {0, 128, 255}}};
  for (const ColourCase& c : cases) {
    for (const PlyForm form : kForms) {
      PlyBuilder ply(form);
      ply.element("vertex", 1).property("float", "x").property("float", "y").property("float", "z");
      for (const char* name : {"diffuse_red", "diffuse_green", "diffuse_blue"}) ply.property(c.type, name);
      for (int i = 0; i < 3; ++i) ply.value("float", i);
      for (const double v : c.values) ply.value(c.type, v);
      const auto cloud = parse_text(ply.text());
      ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
      ASSERT_THAT(cloud->colors, SizeIs(1));
      EXPECT_THAT(cloud->colors[0], ElementsAre(c.expected[0], c.expected[1], c.expected[2], 255)) << c.type;
    }
  }
}

constexpr std::string_view kThreeAxes = "property float x\nproperty float y\nproperty float z\n";

TEST(PlyReader, drops_colours_that_are_not_finite_with_a_warning) {
  const auto cloud = parse_text("ply\nformat ascii 1.0\nelement vertex 2\n" + std::string(kThreeAxes) +
                                "property float red\nproperty float green\nproperty float blue\nend_header\n"
                                "0 0 0 1 1 1\n1 1 1 0 nan 0\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_THAT(cloud->colors, IsEmpty());
  EXPECT_THAT(cloud->warnings, ElementsAre(HasSubstr("point 1")));
}

TEST(PlyReader, says_which_attributes_it_ignores) {
  const auto cloud = parse_text("ply\nformat ascii 1.0\nelement vertex 1\n" + std::string(kThreeAxes) +
                                "property float nx\nproperty uchar red\nend_header\n0 0 0 1 1\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_THAT(cloud->warnings, ElementsAre(HasSubstr("normals"), HasSubstr("colours")));
}

TEST(PlyReader, reads_headers_with_any_line_end_comments_and_blank_lines) {
  const std::string body = "1 2 3\n";
  const std::string header = "ply\ncomment a b c\nformat ascii 1.0\n\nobj_info x\nelement vertex 1\n" +
                             std::string(kThreeAxes) + "comment\nend_header\n";
  EXPECT_EQ(code_of(parse_text(header + body)), "ok");
  EXPECT_EQ(code_of(parse_text(with_crlf(header + body))), "ok");
  std::string old_mac = header;
  std::ranges::replace(old_mac, '\n', '\r');
  EXPECT_EQ(code_of(parse_text(old_mac + "1 2 3\r")), "ok");
}

TEST(PlyReader, keeps_a_first_data_byte_that_looks_like_a_line_end) {
  for (const bool crlf : {false, true}) {
    PlyBuilder ply(PlyForm::little);
    ply.element("vertex", 1).property("uchar", "x").property("uchar", "y").property("uchar", "z");
    std::string header = ply.text();
    if (crlf) header = with_crlf(header);
    const auto cloud = parse_text(header + "\n\r\n");
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    EXPECT_THAT(cloud->positions[0], ElementsAre(10, 13, 10));
  }
}

TEST(PlyReader, reads_numbers_as_everybody_writes_them) {
  const std::vector<std::pair<std::string, double>> cases{
      {"+1.5", 1.5},
      {"1e3", 1000},
      {"1.5E-2", 0.015},
      {".5", 0.5},
      {"5.", 5},
      {"-0", -0.0},
      {"1e-400", 0},
      {"1e400", HUGE_VAL},
      {"-1e400", -HUGE_VAL},
      {"inf", HUGE_VAL},
      {"-Infinity", -HUGE_VAL},
      {"1.#INF", HUGE_VAL},
      {"-1.#INF00", -HUGE_VAL},
      {"123456789012345678901234567890", 123456789012345678901234567890.0}};
  for (const auto& [text, expected] : cases) {
    const auto cloud = parse_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n" +
        text + "\t 0  0");
    ASSERT_TRUE(cloud.ok()) << text << ": " << detail_of(cloud);
    EXPECT_EQ(cloud->positions[0][0], expected) << text;
    EXPECT_EQ(std::signbit(cloud->positions[0][0]), std::signbit(expected)) << text;
  }
  for (const std::string text : {"nan", "NaN", "-nan", "nan(ind)", "1.#QNAN", "-1.#IND", "1.#SNAN0"}) {
    const auto cloud = parse_text("ply\nformat ascii 1.0\nelement vertex 1\n" + std::string(kThreeAxes) +
                                  "end_header\n0 " + text + " 0");
    ASSERT_TRUE(cloud.ok()) << text << ": " << detail_of(cloud);
    EXPECT_TRUE(std::isnan(cloud->positions[0][1])) << text;
  }
}

TEST(PlyReader, refuses_text_that_is_no_number_of_its_type) {
  for (const auto& [type, text] : std::vector<std::pair<std::string, std::string>>{{"float", "1,5"},
                                                                                   {"float", "0x10"},
                                                                                   {"float", "abc"},
                                                                                   {"float", "1.5f"},
                                                                                   {"uchar", "256"},
                                                                                   {"uchar", "-1"},
                                                                                   {"int", "1.5"},
                                                                                   {"char", "128"},
                                                                                   {"int", "99999999999"},
                                                                                   {"float", "--1"},
                                                                                   {"float", "+-1"},
                                                                                   {"float", std::string(600, '1')}}) {
    const auto cloud = parse_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty " + type +
                                  " x\nproperty float y\nproperty float z\nend_header\n" + text + " 0 0\n");
    EXPECT_EQ(code_of(cloud), "malformed_input") << type << " " << text;
    EXPECT_THAT(detail_of(cloud), HasSubstr("'x'"));
  }
}

TEST(PlyReader, takes_whole_numbers_with_a_point_for_integers) {
  const auto cloud = parse_text(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\nend_header\n1.0 2e2 "
      "-3.\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_THAT(cloud->positions[0], ElementsAre(1, 200, -3));
}

TEST(PlyReader, reads_the_same_under_a_locale_with_decimal_commas) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"}) std::setlocale(LC_ALL, name);
  const auto cloud = parse_text("ply\nformat ascii 1.0\nelement vertex 1\n" + std::string(kThreeAxes) +
                                "end_header\n0.5 1.25 -2.75\n");
  std::setlocale(LC_ALL, before.c_str());
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_THAT(cloud->positions[0], ElementsAre(0.5, 1.25, -2.75));
}

TEST(PlyReader, rounds_what_a_float_property_holds_to_float32) {
  const auto cloud = parse_text(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty double y\nproperty float z\nend_header\n0.1 "
      "0.1 16777217\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_THAT(cloud->positions[0], ElementsAre(static_cast<double>(0.1F), 0.1, 16777216));
}

TEST(PlyReader, streams_a_file_to_the_same_cloud_as_from_memory) {
  PlyBuilder ascii(PlyForm::ascii);
  PlyBuilder binary(PlyForm::big);
  for (PlyBuilder* ply : {&ascii, &binary}) {
    ply->element("vertex", 50000)
        .property("float", "x")
        .property("double", "y")
        .list("uchar", "int", "tags")
        .property("short", "z");
    for (int i = 0; i < 50000; ++i) {
      ply->value("float", i * 0.1).value("double", i / 3.0);
      ply->list_value("uchar", "int", std::vector<double>(static_cast<std::size_t>(i % 5), 1.0))
          .value("short", i % 1000)
          .end_row();
    }
    const std::string text = ply->text();
    const auto path = std::filesystem::path(::testing::TempDir()) / "surfaced_streamed.ply";
    ASSERT_TRUE(write_file(path, testing::as_bytes(text)).ok());
    const auto streamed = read_cloud(path);
    const auto parsed = parse_text(text);
    std::filesystem::remove(path);
    ASSERT_TRUE(streamed.ok()) << detail_of(streamed);
    ASSERT_TRUE(parsed.ok()) << detail_of(parsed);
    EXPECT_EQ(streamed->positions, parsed->positions);
    EXPECT_THAT(streamed->positions, SizeIs(50000));
  }
}

TEST(PlyReader, says_how_much_follows_the_last_element) {
  for (const PlyForm form : kForms) {
    PlyBuilder ply(form);
    ply.element("vertex", 1).property("uchar", "x").property("uchar", "y").property("uchar", "z");
    for (int i = 0; i < 2; ++i) ply.value("uchar", 100).value("uchar", 101).value("uchar", 102).end_row();
    const auto cloud = parse_text(ply.text());
    ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
    EXPECT_THAT(cloud->positions, SizeIs(1));
    EXPECT_THAT(cloud->warnings, ElementsAre(HasSubstr(" bytes after the last element ignored")));
  }
  EXPECT_THAT(
      parse_text("ply\nformat ascii 1.0\nelement vertex 1\n" + std::string(kThreeAxes) + "end_header\n1 2 3\n\n \r\n")
          ->warnings,
      IsEmpty());
}

TEST(PlyMesh, cuts_polygons_into_fans_and_leaves_degenerate_triangles_out) {
  for (const PlyForm form : kForms) {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      PlyBuilder ply(form);
      ply.element("vertex", 5).property("float", "x").property("float", "y").property("float", "z");
      ply.element("face", 4).property("uchar", "flags").list("uchar", "int", name);
      for (int i = 0; i < 5; ++i) ply.value("float", i).value("float", i * i).value("float", 0).end_row();
      for (const std::vector<double>& face :
           std::vector<std::vector<double>>{{0, 1, 2}, {0, 1, 2, 3, 4}, {3, 3, 4}, {1, 2}}) {
        ply.value("uchar", 7).list_value("uchar", "int", face).end_row();
      }
      std::vector<std::string> warnings;
      const auto mesh = decode_mesh(ply.bytes(), "test.ply", &warnings);
      ASSERT_TRUE(mesh.ok()) << detail_of(mesh);
      ASSERT_THAT(mesh->triangles, SizeIs(4));
      EXPECT_EQ(mesh->triangles[3][2].value, 4U);
      EXPECT_THAT(warnings, ElementsAre("1 triangles with a repeated vertex left out"));
    }
  }
}

TEST(PlyMesh, refuses_indices_that_are_no_vertices) {
  for (const PlyForm form : kForms) {
    for (const double index : {3.0, -1.0, 2147483647.0}) {
      PlyBuilder ply(form);
      ply.element("vertex", 3).property("float", "x").property("float", "y").property("float", "z");
      ply.element("face", 1).list("uchar", "int", "vertex_indices");
      for (int i = 0; i < 3; ++i) ply.value("float", i).value("float", i * i).value("float", 0).end_row();
      ply.list_value("uchar", "int", {0, 1, index}).end_row();
      const auto mesh = decode_mesh(ply.bytes(), "test.ply");
      EXPECT_EQ(code_of(mesh), "malformed_input");
      EXPECT_THAT(detail_of(mesh), HasSubstr(std::to_string(static_cast<long>(index))));
    }
  }
}

TEST(PlyMesh, refuses_a_cloud) {
  PlyBuilder ply(PlyForm::little);
  ply.element("vertex", 1).property("uchar", "x").property("uchar", "y").property("uchar", "z");
  EXPECT_EQ(code_of(decode_mesh(bytes_of(ply.text() + "abc"), "test.ply")), "unsupported_feature");
}

}  // namespace
}  // namespace surfaced
