// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/strangers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "io/scalars.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

using namespace std::string_view_literals;
using Stranger = std::pair<std::string_view, std::string_view>;

/// Enough of a file to show what it is.
constexpr std::size_t kShown = 16;

constexpr std::string_view kPicture = "a picture, not points: a mesh from photos takes a photogrammetry program first";
constexpr std::string_view kPacked =
    "an archive that is not read here; unpack it and send the cloud in it, or pack it as gzip or ZIP";
constexpr std::string_view kPickle =
    "a pickle of Python; write its points as text with numpy.savetxt(\"points.xyz\", points[:, :3])";
constexpr std::string_view kExport = "export its points as PLY, LAS, PCD or text with x y z";

/// First bytes of binary files.
constexpr auto kBinary = std::to_array<Stranger>({
    {"\x89PNG"sv, kPicture},
    {"\xff\xd8\xff"sv, kPicture},
    {"GIF8"sv, kPicture},
    {"II*\0"sv, kPicture},
    {"MM\0*"sv, kPicture},
    {"II+\0"sv, kPicture},
    {"MM\0+"sv, kPicture},
    {"\0\0\x01\0"sv, kPicture},
    {"\0\0\0\x0cjP  "sv, kPicture},
    {"\0\0\0\x0cJXL "sv, kPicture},
    {"DDS "sv, kPicture},
    {"\xabKTX"sv, kPicture},
    {"\x76\x2f\x31\x01"sv, kPicture},
    {"#?RADIANCE"sv, kPicture},
    {"ASTM-E57"sv,
     "an E57 scan, which is not read here; convert it to LAS, PLY or PTS, for example with 'pdal translate in.e57 "
     "out.las'"},
    {"\x93NUMPY"sv, "a NumPy array; write its rows as text with numpy.savetxt(\"points.xyz\", array[:, :3])"},
    {"Kaydara FBX Binary"sv, "an FBX scene; export it as GLB, OBJ or PLY"},
    {"BLENDER"sv, "a Blender file; export it as GLB, OBJ or PLY"},
    {"PXR-USDC"sv, "a USD scene; export it as GLB, OBJ or PLY"},
    {"AutoCAD Binary DXF"sv, "a binary DXF drawing; export its points as text with x y z"},
    {"AC10"sv, "a DWG drawing; export its points as text with x y z"},
    {"\x89HDF"sv, "an HDF5 file; write its points as text with x y z, or as PLY"},
    {"CDF\x01"sv, "a NetCDF file; write its points as text with x y z, or as PLY"},
    {"CDF\x02"sv, "a NetCDF file; write its points as text with x y z, or as PLY"},
    {"CDF\x05"sv, "a NetCDF file; write its points as text with x y z, or as PLY"},
    {" BDV\0"sv, "an OpenVDB volume; make a mesh of it, or write its points as PLY"},
    {"NRRD0"sv, "an NRRD volume; make a mesh of it, or write its points as PLY"},
    {"ARROW1\0"sv, "an Arrow table; write it as CSV"},
    {"\x80\x02"sv, kPickle},
    {"\x80\x03"sv, kPickle},
    {"\x80\x04"sv, kPickle},
    {"\x80\x05"sv, kPickle},
    {"\0\0\x27\x0a"sv, "a shapefile of ESRI; export its points as text with x y z"},
    {"\xff\xfe\xff\x0eS\0k\0"sv, "a SketchUp model; export it as GLB, OBJ or STL"},
    {"MATLAB 5.0"sv, "a MATLAB file; write its points with writematrix(points, 'points.xyz', 'FileType', 'text')"},
    {"#ROSBAG"sv, "a ROS bag; write its clouds as PCD with 'rosrun pcl_ros bag_to_pcd'"},
    {"\x89MCAP"sv, "an MCAP recording; write its clouds as PCD or PLY"},
    {"\xd4\xc3\xb2\xa1"sv,
     "a capture of network packets; write its clouds as PCD, LAS or PLY with the scanner's program"},
    {"\xa1\xb2\xc3\xd4"sv,
     "a capture of network packets; write its clouds as PCD, LAS or PLY with the scanner's program"},
    {"\x0a\x0d\x0d\x0a"sv,
     "a capture of network packets; write its clouds as PCD, LAS or PLY with the scanner's program"},
    {"SQLite format 3"sv, "an SQLite database; export its points as text with x y z"},
    {"\xd0\xcf\x11\xe0"sv,
     "a document of old Office, Revit or 3ds Max; save its table as CSV, or export its scene as GLB, OBJ or PLY"},
    {"PAR1"sv, "a Parquet table; write it as CSV"},
    {"%PDF"sv, "a PDF document, not points"},
    {"\x7f"
     "ELF"sv,
     "a program, not points"},
    {"MZ"sv, "a program, not points"},
    {"\xff\xfe\0\0"sv, "text in UTF-32; save it as UTF-8"},
    {"\0\0\xfe\xff"sv, "text in UTF-32; save it as UTF-8"},
    {"8BPS"sv, kPicture},
    {"SIMPLE  ="sv, kPicture},
    {"OCTM"sv, "an OpenCTM mesh; export it as OBJ, STL or PLY"},
    {"CCB2"sv, "a project of CloudCompare; save its clouds as PLY or LAS there"},
    {"CCB3"sv, "a project of CloudCompare; save its clouds as PLY or LAS there"},
    {"**ABCDEF"sv, "a Parasolid model of CAD; export it as GLB, OBJ or STL"},
    {"V5_CFV2"sv, "a CATIA model of CAD; export it as GLB, OBJ or STL"},
    {"xof 0"sv, "a DirectX scene; export it as GLB, OBJ or PLY"},
    {"VOX "sv, "a voxel model; make a mesh of it, or write its points as PLY"},
    {"GRIB"sv, "a GRIB file of weather, not points"},
    {"Obj\x01"sv, "an Avro table; write it as CSV"},
    {"\x1f\x9d"sv, kPacked},
    {"\x04\x22\x4d\x18"sv, kPacked},
    {"MSCF"sv, kPacked},
    {"3D Geometry File Format"sv, "a Rhino model; export it as OBJ, STL or PLY"},
    {"NGSP"sv, "SPZ, packed Gaussian splats; convert it to PLY"},
    {"7z\xbc\xaf"sv, kPacked},
    {"Rar!"sv, kPacked},
    {"BZh"sv, kPacked},
    {"\xfd"
     "7zXZ"sv,
     kPacked},
    {"\x28\xb5\x2f\xfd"sv, kPacked},
});

/// First words of text, in lower case; blanks before them do not count.
constexpr auto kText = std::to_array<Stranger>({
    {"version https://git-lfs"sv,
     "a Git LFS pointer, not the file that it stands for; run 'git lfs pull' and send that"},
    {"<!doctype html"sv, "a web page, not points: the download has answered with an error or a login"},
    {"<html"sv, "a web page, not points: the download has answered with an error or a login"},
    {"; fbx"sv, "an FBX scene; export it as GLB, OBJ or PLY"},
    {"#usda"sv, "a USD scene; export it as GLB, OBJ or PLY"},
    {"ncols"sv, "an ESRI grid of heights; write its cells as x y z with 'gdal_translate -of XYZ in.asc out.xyz'"},
    {"dsaa"sv, "a Surfer grid of heights; write its cells as x y z with 'gdal_translate -of XYZ in.grd out.xyz'"},
    {"#vrml"sv, "a VRML scene; export it as GLB, OBJ or PLY"},
    {"#x3d"sv, "an X3D scene; export it as GLB, OBJ or PLY"},
    {"# vtk datafile"sv, "a VTK file; write it as PLY with ParaView or vtkPLYWriter"},
    {"iso-10303-21"sv, "a STEP file"},
    {"//maya"sv, "a Maya scene; export it as GLB, OBJ or PLY"},
    {"off"sv, "an OFF mesh; convert it to OBJ or PLY"},
    {"coff"sv, "an OFF mesh; convert it to OBJ or PLY"},
    {"noff"sv, "an OFF mesh; convert it to OBJ or PLY"},
    {"ac3db"sv, "an AC3D scene; export it as GLB, OBJ or PLY"},
    {"newmtl"sv, "the materials of an OBJ, not points; send the .obj beside it"},
    {"#inventor"sv, "an Open Inventor scene; export it as GLB, OBJ or PLY"},
    {"# amiramesh"sv, "an Amira file; write its points as text with x y z, or as PLY"},
    {"$meshformat"sv, "a Gmsh mesh; export it as STL or PLY"},
    {"%!ps"sv, "a PostScript document, not points"},
    {"{\\rtf"sv, "a text document with its layout; save it as plain text"},
});

/// What an XML document is told by, in lower case.
constexpr auto kXml = std::to_array<Stranger>({
    {"<html"sv, "a web page, not points: the download has answered with an error or a login"},
    {"<vtkfile"sv, "a VTK file; write it as PLY with ParaView or vtkXMLPolyDataReader and vtkPLYWriter"},
    {"<collada"sv, "a COLLADA scene; export it as GLB, OBJ or PLY"},
    {"<x3d"sv, "an X3D scene; export it as GLB, OBJ or PLY"},
    {"<svg"sv, "an SVG picture, not points"},
    {"<gpx"sv, "a GPX track; export its points, projected to metres, as text with x y z"},
    {"<kml"sv, "a KML document; export its points, projected to metres, as text with x y z"},
    {"<landxml"sv, "a LandXML document; export its points as text with x y z"},
    {"<amf"sv, "an AMF model; convert it to 3MF, STL or PLY"},
    {"citygml"sv, "a CityGML model; export its points as text with x y z"},
    {"<error"sv, "an error message of a server, not points"},
});

/// Whether text may begin so too: a label of a surveyor, for example.
bool may_be_text(std::string_view magic) {
  return magic.size() <= 4 && magic != "%PDF" &&
         std::ranges::all_of(magic, [](char c) { return c >= ' ' && c <= '~'; });
}

bool has_control(std::span<const std::byte> start) {
  return std::ranges::any_of(start.first(std::min<std::size_t>(start.size(), 512)),
                             [](std::byte b) { return b < std::byte{9} || (b > std::byte{13} && b < std::byte{32}); });
}

/// DXF: pairs of lines, a number of a group and its value; comments have the number 999.
bool is_dxf(std::string_view text) {
  std::array<std::string_view, 2> lines;
  for (std::size_t k = 0; k < 64 && !text.empty(); ++k) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.at(k % 2) = trimmed(line);
    if (k % 2 == 0) continue;
    if (lines[0] == "0") return lines[1] == "SECTION";
    if (lines[0] != "999") return false;
  }
  return false;
}

/// A picture of Netpbm: its letter and number alone in the first line, and not as the label of a point.
bool is_netpbm(std::string_view text) {
  return text.size() > 4 && text[0] == 'P' && std::string_view("1234567Ff").find(text[1]) != text.npos &&
         (text[2] == '\n' || text[2] == '\r');
}

/// IGES: lines of 80 columns, of which the 73rd says the section and the last seven the number.
bool is_iges(std::string_view text) {
  constexpr std::size_t kSection = 72;
  if (text.size() < 80 || text.substr(0, 80).find('\n') != text.npos || text[kSection] != 'S') return false;
  const std::string_view number = trimmed(text.substr(kSection + 1, 7));
  return !number.empty() && std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
}

/// 3DS: a chunk of everything, with one of the version or of the meshes in it.
bool is_3ds(std::string_view text) {
  return text.size() >= 8 && text.starts_with("MM") && (text.substr(6, 2) == "\x02\0"sv || text.substr(6, 2) == "==");
}

/// Gaussians in records of 32 bytes, without a header: a place, three scales, a colour, and a rotation whose bytes are
/// a unit quaternion in each of them.
bool is_splat(std::string_view text) {
  constexpr std::size_t kRecord = 32;
  constexpr std::size_t kLookedAt = 16;
  constexpr double kFar = 1e6;
  if (text.size() < kLookedAt * kRecord) return false;
  for (std::size_t i = 0; i < kLookedAt; ++i) {
    const std::string_view record = text.substr(i * kRecord, kRecord);
    for (std::size_t k = 0; k < 6; ++k) {
      const auto x = static_cast<double>(load_little<float>(reinterpret_cast<const std::byte*>(record.data()) + 4 * k));
      if (!(std::abs(x) < kFar) || (k >= 3 && !(x > 0))) return false;
    }
    double length = 0;
    for (std::size_t k = 28; k < kRecord; ++k) {
      const double q = (static_cast<double>(static_cast<unsigned char>(record[k])) - 128) / 128;
      length += q * q;
    }
    if (std::abs(length - 1) > 0.05) return false;
  }
  return true;
}

/// Behind lines of comments.
std::string_view without_comments(std::string_view text) {
  while (text.starts_with('#') || text.starts_with('\n') || text.starts_with('\r')) {
    text.remove_prefix(std::min(text.size(), text.starts_with('#') ? text.find('\n') : 1));
  }
  return text;
}

/// Whether text in square brackets is JSON: it goes on with a value, not with the name of a section.
bool begins_json_array(std::string_view text) {
  if (!text.starts_with('[')) return false;
  const std::size_t next = text.find_first_not_of(" \t\r\n", 1);
  return next == text.npos || std::string_view("[{\"]-0123456789").find(text[next]) != std::string_view::npos;
}

/// A page, or a piece of one, that does not begin as one.
bool is_web_page(std::string_view text) {
  if (text.starts_with("<!--")) return text.find("<html") != text.npos || text.find("<body") != text.npos;
  constexpr auto kTags = std::to_array<std::string_view>(
      {"<head", "<body", "<title", "<meta", "<script", "<div", "<center", "<style", "<link", "<h1", "<pre"});
  return std::ranges::any_of(kTags, [&](std::string_view tag) { return text.starts_with(tag); });
}

/// What an object or array of JSON that is no glTF may be.
std::string json_kind(const std::string& text) {
  const std::string way = "; write its points as text, x y z in a line each";
  if (text.find("\"featurecollection\"") != std::string::npos) return "GeoJSON" + way + ", projected to metres";
  if (text.find("\"cityjson\"") != std::string::npos) return "CityJSON" + way;
  return "JSON" + way;
}

std::optional<std::string> text_stranger(std::string_view start) {
  const std::string text = in_lower_case(start);
  for (const auto& [word, what] : kText) {
    if (!text.starts_with(word)) continue;
    // A word, not the beginning of another.
    const char next = text.size() > word.size() ? text[word.size()] : ' ';
    if (word.ends_with("off") && next > ' ') continue;
    if (word != "iso-10303-21") return std::string(what);
    const bool building = text.find("ifc") != std::string::npos;
    return std::string(building ? "an IFC building model" : "a STEP model of CAD") + "; export it as GLB, OBJ or STL";
  }
  if (is_dxf(start)) return "a DXF drawing; export its points as text with x y z, or its faces as OBJ or STL";
  if (is_iges(start)) return "an IGES model of CAD; export it as GLB, OBJ or STL";
  if (is_netpbm(start)) return std::string(kPicture);
  if (without_comments(text).starts_with("newmtl")) return text_stranger("newmtl ");
  if (begins_json_array(text)) return json_kind(text);
  if (is_web_page(text)) return text_stranger("<html");
  if (!text.starts_with("<?xml") && !text.starts_with('<')) return std::nullopt;
  for (const auto& [word, what] : kXml) {
    if (text.find(word) != std::string::npos) return std::string(what);
  }
  if (!text.starts_with("<?xml") && (text.size() < 2 || text.find("</") == text.npos)) return std::nullopt;
  return "an XML document; " + std::string(kExport);
}

}  // namespace

bool starts_with(std::span<const std::byte> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin(), [](char a, std::byte b) {
           return static_cast<unsigned char>(a) == std::to_integer<unsigned char>(b);
         });
}

std::string shown(std::span<const std::byte> bytes) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string hex;
  std::string text;
  for (const std::byte b : bytes.first(std::min(bytes.size(), kShown))) {
    const auto value = std::to_integer<unsigned>(b);
    hex += hex.empty() ? "" : " ";
    hex += kHex[value >> 4];
    hex += kHex[value & 15U];
    text += value >= ' ' && value <= '~' ? static_cast<char>(value) : '.';
  }
  return "'" + text + "' (" + hex + ")";
}

std::optional<std::string> stranger_in(std::span<const std::byte> start) {
  for (const auto& [magic, what] : kBinary) {
    if (starts_with(start, magic) && (!may_be_text(magic) || has_control(start))) return std::string(what);
  }
  std::string_view text = text_of(start);
  if (text.substr(0, 4) == "RIFF" && text.size() >= 12) {
    return std::string(text.substr(8, 4) == "WEBP" ? kPicture : "a recording of sound or film, not points");
  }
  if (text.size() >= 12 && text.substr(4, 4) == "ftyp") {
    const std::string_view brand = text.substr(8, 4);
    const bool still = brand.starts_with("hei") || brand.starts_with("avif") || brand == "mif1";
    return std::string(still ? kPicture : "a recording of sound or film, not points");
  }
  if (text.size() >= 12 && text.starts_with("FORM") && text.substr(8, 3) == "LWO")
    return "a LightWave scene; export it as GLB, OBJ or PLY";
  if (text.starts_with("Version ") && text.substr(0, 80).find(" JT ") != text.npos) {
    return "a JT model of CAD; export it as GLB, OBJ or STL";
  }
  if (is_3ds(text)) return "a 3ds Max scene; export it as GLB, OBJ or PLY";
  if (text.size() >= 262 && text.substr(257, 5) == "ustar") return std::string(kPacked);
  if (text.starts_with("BM") && text.size() >= 14 && text.substr(6, 4) == "\0\0\0\0"sv) return std::string(kPicture);
  if (has_control(start) && is_splat(text)) {
    return "a .splat of Gaussians, without a header; convert it to PLY, whose colours and opacities are read";
  }
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return std::nullopt;
  // The blanks before its first number belong to a DXF.
  if (is_dxf(text)) return text_stranger(text);
  return text_stranger(text.substr(first));
}

std::string json_stranger(std::string_view start) { return json_kind(in_lower_case(start)); }

}  // namespace surfaced::io
