// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds in the formats of scanners and other programs, made by hand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "support/ply_files.hpp"

namespace surfaced::testing {

/// Little-endian bytes, one value after the other.
class ByteWriter {
 public:
  template <class T>
  ByteWriter& put(T value) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    text.append(raw.data(), raw.size());
    return *this;
  }
  ByteWriter& zeros(std::size_t count) {
    text.append(count, '\0');
    return *this;
  }
  ByteWriter& put_text(const std::string& value) {
    text += value;
    return *this;
  }
  std::string text;
};

struct LasPoint {
  std::array<std::int32_t, 3> xyz{};
  std::array<std::uint16_t, 3> rgb{};
};

struct LasOptions {
  int minor = 2;
  int format = 2;
  std::array<double, 3> scale{0.001, 0.001, 0.001};
  std::array<double, 3> offset{};
  /// Declared number of points; -1: as many as there are.
  std::int64_t declared = -1;
  /// Where waveforms begin, from version 1.3 on; 0: nowhere.
  std::uint64_t waveforms = 0;
};

inline std::string las_file(const std::vector<LasPoint>& points, const LasOptions& options = {}) {
  constexpr std::array<std::uint16_t, 11> kLength{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  constexpr std::array<std::size_t, 11> kColor{0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
  const auto format = static_cast<std::size_t>(options.format & 63);
  const std::uint16_t header = options.minor < 3 ? 227 : options.minor == 3 ? 235 : 375;
  const auto count =
      static_cast<std::uint64_t>(options.declared < 0 ? static_cast<std::int64_t>(points.size()) : options.declared);
  ByteWriter w;
  w.put_text("LASF").zeros(20).put<std::uint8_t>(1).put(static_cast<std::uint8_t>(options.minor)).zeros(68);
  w.put(header).put<std::uint32_t>(header).put<std::uint32_t>(0).put(static_cast<std::uint8_t>(options.format));
  w.put(kLength.at(format)).put(static_cast<std::uint32_t>(options.minor == 4 && format > 5 ? 0 : count)).zeros(20);
  for (const double x : options.scale) w.put(x);
  for (const double x : options.offset) w.put(x);
  w.zeros(48);
  if (options.minor >= 3) w.put(options.waveforms);
  if (options.minor == 4) w.zeros(12).put(count).zeros(120);
  for (const LasPoint& p : points) {
    const std::size_t begin = w.text.size();
    for (const std::int32_t x : p.xyz) w.put(x);
    if (kColor.at(format) != 0) {
      w.zeros(kColor.at(format) - 12);
      for (const std::uint16_t c : p.rgb) w.put(c);
    }
    w.zeros(kLength.at(format) - (w.text.size() - begin));
  }
  return w.text;
}

using Facets = std::vector<std::array<std::array<float, 3>, 3>>;

inline Facets two_facets() { return {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {{{1, 0, 0}, {1, 1, 0.5F}, {0, 1, 0}}}}; }

inline std::string binary_stl(const Facets& facets, const std::string& header = "made by hand") {
  ByteWriter w;
  w.put_text(header).zeros(80 - header.size()).put(static_cast<std::uint32_t>(facets.size()));
  for (const auto& facet : facets) {
    w.zeros(12);
    for (const auto& corner : facet) {
      for (const float x : corner) w.put(x);
    }
    w.zeros(2);
  }
  return w.text;
}

inline std::string ascii_stl(const Facets& facets) {
  std::string text = "solid by hand\n";
  for (const auto& facet : facets) {
    text += "facet normal 0 0 1\n  outer loop\n";
    for (const auto& c : facet) {
      text += "    vertex " + std::to_string(c[0]) + " " + std::to_string(c[1]) + " " + std::to_string(c[2]) + "\n";
    }
    text += "  endloop\nendfacet\n";
  }
  return text + "endsolid by hand\n";
}

/// x y z, normals, packed colour, and a field of three values that nobody knows.
inline std::string pcd_header(std::size_t points, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb normal_x normal_y normal_z odd\n"
         "SIZE 4 4 8 4 4 4 4 1\nTYPE F F F U F F F U\nCOUNT 1 1 1 1 1 1 1 3\nWIDTH " +
         std::to_string(points) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}

inline std::string pcd_ascii() {
  return pcd_header(3, "ascii") +
         "1.5 2 3.25 66051 0 0 1 1 2 3\nnan nan nan 0 0 0 1 1 2 3\n-1 -2 -3 16711680 1 0 0 1 2 3\n";
}

/// The columns of two points, of 35 bytes each.
inline std::string pcd_columns() {
  ByteWriter w;
  w.put(1.5F)
      .put(-1.0F)
      .put(2.0F)
      .put(-2.0F)
      .put(3.25)
      .put(-3.0)
      .put(std::uint32_t{66051})
      .put(std::uint32_t{16711680});
  w.put(0.0F).put(1.0F).put(0.0F).put(0.0F).put(1.0F).put(0.0F).zeros(6);
  return w.text;
}

inline std::string pcd_binary() {
  ByteWriter w;
  w.put(1.5F).put(2.0F).put(3.25).put(std::uint32_t{66051}).put(0.0F).put(0.0F).put(1.0F).zeros(3);
  w.put(-1.0F).put(-2.0F).put(-3.0).put(std::uint32_t{16711680}).put(1.0F).put(0.0F).put(0.0F).zeros(3);
  return pcd_header(2, "binary") + w.text;
}

/// LZF of literal runs, with the last six zeros as a reference back.
inline std::string lzf_of(const std::string& plain) {
  std::string packed;
  const std::size_t literal = plain.size() - 5;
  for (std::size_t at = 0; at < literal; at += 32) {
    const std::size_t length = std::min<std::size_t>(32, literal - at);
    packed += static_cast<char>(length - 1) + plain.substr(at, length);
  }
  return packed + std::string("\x60\x00", 2);  // 5 bytes like the one before
}

inline std::string pcd_compressed() {
  const std::string plain = pcd_columns();
  const std::string packed = lzf_of(plain);
  ByteWriter w;
  w.put(static_cast<std::uint32_t>(packed.size())).put(static_cast<std::uint32_t>(plain.size())).put_text(packed);
  return pcd_header(2, "binary_compressed") + w.text;
}

inline constexpr std::string_view kObj =
    "# by hand\nmtllib none.mtl\nv 1 2 3 1 0 0.5\nv 4 5 6 0 1 0\nv 7 8 9.25 0 0 1\nv 1 1 1 1 1 1\nvn 0 0 1\n"
    "g part\nf 1//1 2//1 3//1 4//1\nf -4 -1 -2\n";

/// One valid text of every kind.
inline std::vector<std::pair<std::string, std::string>> text_clouds() {
  return {
      {"plain.xyz", "1 2 3\n4.5\t5 6\n\n7 8 9e1\n"},
      {"colors.xyz", "# made by hand\n1 2 3 255 0 7\n4 5 6 0 128 9\n"},
      {"normals.xyz", "1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n"},
      {"both.xyz", "1 2 3 0 0 1 9 8 7\n4 5 6 -1 0 0 6 5 4\n"},
      {"header.csv", "id,Y,X,Z,Red,Green,Blue,\"nx\",ny,nz\n1,2,1,3,0.5,0,1,0,0,1\n2,5,4,6,1,1,0,0,1,0\n"},
      {"decimal_comma.csv", "x;y;z\r\n1,5;2;3\r\n4;5;6,25\r\n"},
      {"cloud_compare.txt", "//X Y Z R G B\n1 2 3 10 20 30\n4 5 6 40 50 60\n"},
      {"cloud_compare_count.txt", "//X Y Z Scalar field\n2\n1 2 3 10\n4 5 6 40\n"},
      {"survey.csv", "Point,Easting[m],Northing[m],Elevation,Code\n1,4321.5,5431.25,318,TREE\n2,4322,5432,317.5,\n"},
      {"numbers.csv", "101,4321.5,5431.25,318,TREE\n102,4322,5432,317.5,KERB\n104,4323,5433,nan,\n"},
      {"quoted.csv", "sep=,\n\"Point ID\",\"X\",\"Y\",\"Z\"\n1,\"0,5\",\"1,5\",\"2,5\"\n2,\"3,5\",\"NA\",\"5,5\"\n"},
      {"classes.txt", "exported\n1.5|2|3|65|1|1\n4.5|5|6|64|1|2\n"},
      {"utf16.txt", std::string("\xff\xfe"
                                "1\0 \0"
                                "2\0 \0"
                                "3\0\n\0"
                                "4\0 \0"
                                "5\0 \0"
                                "6\0",
                                24)},
      {"scans.pts", "2\n1 2 3 -100 10 20 30\n4 5 6 7 40 50 60\n1\n7 8 9 0 0 0 0\n"}};
}

}  // namespace surfaced::testing
