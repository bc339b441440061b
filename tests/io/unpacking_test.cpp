// SPDX-License-Identifier: GPL-3.0-or-later
// Files in gzip and ZIP archives, and files that are no clouds at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "io/io.hpp"
#include "io/zip.hpp"
#include "support/gzip_files.hpp"
#include "support/results.hpp"
#include "support/scan_files.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::HasSubstr;
using Points = std::vector<Point3>;

std::string zipped(const std::vector<io::ZipEntry>& entries) {
  const std::vector<std::byte> bytes = io::write_zip(entries).value();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(Packed, every_format_is_read_out_of_gzip_and_zip) {
  const std::string las = las_file({{{1000, -2500, 3}, {}}, {{0, 7, -9}, {}}});
  for (const std::string& text :
       {std::string("1 2 3\n4 5 6\n"), las, pcd_binary(), binary_stl(two_facets()), std::string(kObj)}) {
    const Points plain = parse_text(text)->positions;
    for (const std::string& packed :
         {gzipped(text), gzipped("") + gzipped(text), zipped({{"folder/cloud.xyz", text}})}) {
      const auto cloud = parse_text(packed);
      ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
      EXPECT_EQ(cloud->positions, plain);
    }
  }
}

TEST(Packed, a_mesh_is_read_out_of_gzip_too) {
  const std::vector<std::byte> ply = encode_mesh(tetrahedron(), MeshFormat::ply).value();
  const std::string packed = gzipped({reinterpret_cast<const char*>(ply.data()), ply.size()});
  const auto mesh = decode_mesh(as_bytes(packed), "mesh.ply.gz");
  ASSERT_TRUE(mesh.ok()) << detail_of(mesh);
  EXPECT_EQ(mesh->triangles.size(), 4U);
}

TEST(Packed, an_archive_holds_one_cloud_beside_other_files) {
  const std::string xyz = "1 2 3\n4 5 6\n";
  EXPECT_EQ(parse_text(zipped({{"readme.txt", "words"}, {"__MACOSX/._a.ply", "x"}, {"a.xyz", xyz}}))->size(), 2U);
  EXPECT_THAT(detail_of(parse_text(zipped({{"a.xyz", xyz}, {"b.ply", xyz}}))), HasSubstr("2 clouds, 'a.xyz', 'b.ply'"));
  EXPECT_THAT(detail_of(parse_text(zipped({{"a.jpg", xyz}, {"b.doc", xyz}}))), HasSubstr("holds no cloud"));
  EXPECT_THAT(detail_of(parse_text(zipped({{"a.xyz", gzipped(xyz)}}))), HasSubstr("gzip again"));
  EXPECT_THAT(detail_of(parse_text(zipped({{"a.xyz", "no points here\n"}}))), HasSubstr("/a.xyz"));
}

TEST(Packed, what_would_unpack_to_far_more_than_it_is_and_what_is_damaged_are_refused) {
  const std::string bomb = gzipped(std::string(std::size_t{200} << 20, '0'));
  EXPECT_EQ(code_of(parse_text(bomb)), "unsupported_feature");
  EXPECT_EQ(code_of(parse_text(zipped({{"a.xyz", std::string(std::size_t{60} << 20, '0')}}))), "unsupported_feature");
  const std::string good = gzipped("1 2 3\n4 5 6\n");
  for (std::size_t size = 3; size < good.size(); ++size) {
    const auto cut = parse_text(std::string_view(good).substr(0, size));
    if (size < good.size() - 8) {
      EXPECT_EQ(code_of(cut), "truncated_input") << size << detail_of(cut);
    }
    EXPECT_NE(code_of(cut), "internal_error");
  }
  for (std::string text : {good, zipped({{"a.xyz", "1 2 3\n4 5 6\n"}})}) {
    for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
      text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8);
      EXPECT_NE(code_of(parse_text(text)), "internal_error") << bit;
      text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8);
    }
  }
}

/// A glTF whose three points lie in another file.
std::string gltf_with_file(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)"
         R"({"mode":0,"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,)"
         R"("type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
         uri + R"("}]})";
}

std::string nine_floats() {
  ByteWriter w;
  for (int i = 0; i < 9; ++i) w.put(static_cast<float>(i));
  return w.text;
}

TEST(Packed, a_gltf_finds_its_buffer_in_its_archive_and_beside_it_but_nowhere_else) {
  const Points points{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  const auto zip = parse_text(zipped({{"m/a.gltf", gltf_with_file("data%20a.bin")}, {"m/data a.bin", nine_floats()}}));
  ASSERT_TRUE(zip.ok()) << detail_of(zip);
  EXPECT_EQ(zip->positions, points);
  EXPECT_THAT(detail_of(parse_text(zipped({{"a.gltf", gltf_with_file("b.bin")}}))), HasSubstr("has no file 'b.bin'"));
  EXPECT_THAT(detail_of(parse_text(gltf_with_file("b.bin"))), HasSubstr("one ZIP archive"));

  const TemporaryDirectory folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name, std::ios::binary) << text;
    return folder.path() / name;
  };
  write("m/data.bin", nine_floats());
  write("out.bin", nine_floats());
  ReadOptions options;
  options.files_beside = true;
  EXPECT_EQ(read_cloud(write("m/a.gltf", gltf_with_file("data.bin")), options)->positions, points);
  EXPECT_EQ(code_of(read_cloud(folder.path() / "m/a.gltf")), "unsupported_feature");
  for (const std::string uri : {"../out.bin", "%2e%2e/out.bin", "/etc/passwd", "file:///etc/passwd", ""}) {
    const auto refused = read_cloud(write("m/b.gltf", gltf_with_file(uri)), options);
    EXPECT_THAT(detail_of(refused), HasSubstr("leads out")) << uri;
  }
  EXPECT_EQ(code_of(read_cloud(write("m/c.gltf", gltf_with_file("none.bin")), options)), "input_unreadable");
}

TEST(Strangers, are_named_with_a_way_out_and_without_a_list_of_magic_numbers) {
  using namespace std::string_literals;
  const std::vector<std::pair<std::string, std::string>> files{
      {"version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n", "git lfs pull"},
      {"  0\nSECTION\n  2\nENTITIES\n", "DXF"},
      {"999\nmade by\n0\nSECTION\n", "DXF"},
      {R"({"points": [[0,0,0],[1,0,0]]})", "JSON"},
      {R"({"type":"FeatureCollection","features":[]})", "GeoJSON"},
      {"[[1,2,3],[4,5,6]]", "JSON"},
      {"<!DOCTYPE html>\n<html><body>404</body></html>", "web page"},
      {"\n <html lang=\"en\"><head>", "web page"},
      {"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">", "VTK"},
      {"<?xml version=\"1.0\"?>\n<COLLADA>", "COLLADA"},
      {"Kaydara FBX Binary  \0\x1a\0"s, "FBX"},
      {"; FBX 7.3.0 project file\n", "FBX"},
      {"\x93NUMPY\x01\0v\0"s, "numpy.savetxt"},
      {"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0\n", "VTK"},
      {"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\n", "IFC"},
      {"ISO-10303-21;\nHEADER;\n", "STEP"},
      {"\x89PNG\r\n\x1a\n\0\0"s, "picture"},
      {"\xff\xd8\xff\xe0\0\x10JFIF"s, "picture"},
      {"ASTM-E57\x01\0\0\0"s, "E57"},
      {"OFF\n8 6 0\n0 0 0\n", "OFF"},
      {"%PDF-1.7\n", "PDF"},
      {"\x1f\x8b\x08", "gzip"},
      {"7z\xbc\xaf\x27\x1c\0\x04"s, "archive"},
      {"\0\0\0\0\0\0"s, "no format that is read"},
  };
  for (const auto& [text, name] : files) {
    const auto cloud = parse_cloud(as_bytes(text), "the file");
    EXPECT_FALSE(cloud.ok()) << name;
    EXPECT_THAT(detail_of(cloud), HasSubstr(name));
    EXPECT_THAT(detail_of(cloud), ::testing::StartsWith("the file")) << name;
    EXPECT_THAT(detail_of(cloud), ::testing::Not(HasSubstr("'DRACO'"))) << name;
    EXPECT_FALSE(decode_mesh(as_bytes(text), "the file").ok()) << name;
  }
}

TEST(Strangers, are_not_seen_in_labels_that_begin_alike) {
  for (const char* label : {"AC10", "BZh1", "MZ", "offset1", "Rar!"}) {
    const std::string text = std::string(label) + " 1.5 2 3\nb 4 5 6\nc 7 8 9\n";
    EXPECT_EQ(parse_text(text)->size(), 3U) << label;
  }
}

}  // namespace
}  // namespace surfaced
