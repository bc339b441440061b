// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the seeds of the fuzz targets: one small file for every way a reader can take.
//   build/fuzz/make_seeds tests/fuzz/seeds
#include <iostream>

#include "io/io.hpp"
#include "io/zip.hpp"
#include "support/draco_files.hpp"
#include "support/gzip_files.hpp"
#include "support/ply_files.hpp"
#include "support/scan_files.hpp"
#include "support/shapes.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

std::filesystem::path folder;
bool failed = false;

void save(const std::string& name, std::span<const std::byte> bytes) {
  const std::filesystem::path path = folder / name;
  std::filesystem::create_directories(path.parent_path());
  if (const Status status = write_file(path, bytes); !status) {
    std::cerr << status.error().detail << '\n';
    failed = true;
  }
}

void save_text(const std::string& name, std::string_view text) { save(name, bytes_of(text)); }

TriangleMesh painted(TriangleMesh mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.normals.push_back({0, 0.6F, 0.8F});
    mesh.colors.push_back({static_cast<std::uint8_t>(i), 100, 200, 255});
  }
  return mesh;
}

void save_ply_seeds() {
  const std::string header =
      "element vertex 3\nproperty double y\nproperty list uchar short tags\nproperty float x\nproperty int z\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty ushort red\nproperty ushort green\n"
      "property ushort blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string rows =
      "0.5 2 7 -7 1.25 3 0 0 1 9 99 999\n1e3 0 nan -3 0 1 0 65535 0 1\n-inf 1 4 1.5 2 1 0 0 4 5 6\n3 0 1 2\n";
  save_text("ply/ascii.ply", "ply\nformat ascii 1.0\ncomment by hand\n" + header + rows);
  save_text("ply/crlf.ply", with_crlf("ply\nformat ascii 1.0\nobj_info by hand\n" + header + rows));
  for (const bool big : {false, true}) {
    PlyBuilder ply(big ? PlyForm::big : PlyForm::little);
    ply.element("vertex", 2).property("float", "x").property("float", "y").property("double", "z");
    ply.list("uchar", "int", "ring").property("uchar", "red").property("uchar", "green").property("uchar", "blue");
    ply.value("float", 1.5).value("float", 2).value("double", 3.25).list_value("uchar", "int", {7, 8});
    ply.value("uchar", 1).value("uchar", 2).value("uchar", 3);
    ply.value("float", -1).value("float", 0).value("double", 1e300).list_value("uchar", "int", {});
    ply.value("uchar", 4).value("uchar", 5).value("uchar", 6);
    save(big ? "ply/lists_big.ply" : "ply/lists_little.ply", ply.bytes());
  }
  const TriangleMesh mesh = painted(tetrahedron());
  save("ply/cloud.ply", encode_cloud_ply(mesh.positions, mesh.normals, mesh.colors));
}

void save_draco_seeds() {
  for (const DracoFile& file : small_draco_files()) save("draco/" + file.name + ".drc", file.bytes);
}

void save_mesh_seeds() {
  const TriangleMesh mesh = painted(tetrahedron());
  TriangleMesh far = mesh;
  for (Point3& p : far.positions) p = {p[0] + 5.4e6, p[1] + 0.1, p[2]};
  const EncodeOptions up{.quantization_bits = {}, .up = UpAxis::z, .extras_json = R"({"a":[null,{"b":1}]})"};
  save("mesh/painted.glb", encode_mesh(mesh, MeshFormat::glb).value());
  save("mesh/far.glb", encode_mesh(far, MeshFormat::glb, up).value());
  save("mesh/painted.gltf", encode_mesh(mesh, MeshFormat::gltf).value());
  save("mesh/painted.ply", encode_mesh(mesh, MeshFormat::ply).value());
  save("mesh/painted.drc", encode_mesh(mesh, MeshFormat::drc).value());
  for (const auto& [name, compression] :
       {std::pair{"draco", MeshCompression::draco}, {"meshopt", MeshCompression::meshopt}}) {
    EncodeOptions packed;
    packed.compression = compression;
    packed.quantization_bits = compression == MeshCompression::meshopt ? std::optional(12) : std::nullopt;
    save(std::string("mesh/") + name + ".glb", encode_mesh(mesh, MeshFormat::glb, packed).value());
    save(std::string("gltf/") + name + ".gltf", encode_mesh(mesh, MeshFormat::gltf, packed).value());
  }
  save("mesh/painted.obj", encode_mesh(mesh, MeshFormat::obj).value());
  save("mesh/far.stl", encode_mesh(far, MeshFormat::stl).value());
  save("mesh/far.3mf", encode_mesh(far, MeshFormat::threemf).value());
  save_text("mesh/nodes.gltf", kTwoNodes);
}

void save_packed_seeds() {
  std::string gltf(kTwoNodes);
  const std::size_t uri = gltf.find("\"data:");
  const std::size_t end = gltf.find('"', uri + 1);
  gltf.replace(uri, end + 1 - uri, "\"a%20b.bin\"");
  const std::string points = text_clouds().front().second;
  save_text("packed/points.xyz.gz", gzipped(points));
  save_text("packed/members.ply.gz", gzipped("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n") +
                                         gzipped("property float y\nproperty float z\nend_header\n1 2 3\n"));
  save("packed/points.zip", io::write_zip({{"readme.md", "words"}, {"d/points.xyz", points}}).value());
  save("packed/buffers.zip", io::write_zip({{"d/a.gltf", gltf}, {"d/a b.bin", std::string(200, '\1')}}).value());
  save("packed/las.zip", io::write_zip({{"a.las", las_file({{{1, -2, 3}, {}}, {{4, 5, 6}, {}}})}}).value());
  save_text("packed/stranger.gz", gzipped("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"));
}

void save_scan_seeds() {
  for (const auto& [name, text] : text_clouds()) save_text("text/" + name, text);
  save_text("obj/hand.obj", kObj);
  save_text("obj/cloud.obj", "vn 0 0 1\nv 1 2 3\nvn 1 0 0\nv 4 5 6 1\n");
  save_text("stl/binary.stl", binary_stl(two_facets()));
  save_text("stl/far.stl", binary_stl(two_facets(), "surfaced, origin 412000.5 5654000 -2 "));
  save_text("stl/solid.stl", binary_stl(two_facets(), "solid binary"));
  save_text("stl/ascii.stl", ascii_stl(two_facets()));
  save_text("pcd/ascii.pcd", pcd_ascii());
  save_text("pcd/binary.pcd", pcd_binary());
  save_text("pcd/compressed.pcd", pcd_compressed());
  for (const int format : {0, 2, 7}) {
    save_text("las/" + std::to_string(format) + ".las", las_file({{{1, -2, 3}, {65535, 0, 7}}, {{4, 5, 6}, {1, 2, 3}}},
                                                                 {.minor = format == 7 ? 4 : 2, .format = format}));
  }
  save_text("obj/continued.obj", "g \\\nname\nv 1 \\\n 2 3\nv 4 5 6\n");
  save_text("stl/more.stl", binary_stl(two_facets(), "made by hand") + "more");
  save_text("stl/end.stl", ascii_stl(two_facets()) + "# made by a program\n");
  save_text("text/header_without_z.txt", "x y r g b and z\n1 2 0 60 40\n3 4 10 20 30\n");
  save_text("text/empty_rows.csv", "Nr;X;Y;Z;R;G;B\n1;0,5;1;2;9;8;7\n;;;;;;\n2;;;;;;\n3;4;5;6;200;100;50\n");
  save_text("text/prose.txt", "LICENSE\n Version 3, 29 June 2007\nof words\nand words\n1 2 3\nmore words\nof it\n");
  save_text("text/intensity.txt", "1 2 3 87 2 0\n4 5 6 41 2 0\n7 8 9.5 200 5 0\n1 0 0 87 2 0\n");
  save_text("pcd/nothing.pcd",
            "VERSION .7\nFIELDS x y _ z r g b\nSIZE 4 4 1 4 8 8 8\nTYPE F F U F F F F\n"
            "COUNT 1 1 0 1 1 1 1\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3 4 5 6\n");
  save_text("las/fewer.las", las_file({{{1, -2, 3}}, {{4, 5, 6}}}, {.declared = 1}));
  save_text("ply/packed.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float X\nproperty float Y\nproperty float Z\n"
            "property uint rgb\nend_header\n1 2 3 66051\n");
  save_text("ply/splat.ply",
            "ply \nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float opacity\n"
            "property float scale_0\nproperty float rot_0\nend_header\n1 2 3 0.5 0 -1 2 -3 1\n");
  save_packed_seeds();
  save("mesh/archive.zip", io::write_zip({{"folder/a.obj", std::string(kObj)}}).value());
  std::string points(kTwoNodes);
  points.replace(points.find("\"mode\":5"), 8, "\"mode\":0");
  save_text("gltf/points.gltf", points);
  save("gltf/painted.glb", encode_mesh(painted(tetrahedron()), MeshFormat::glb).value());
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::cerr << "make_seeds FOLDER\n";
    return 2;
  }
  folder = arguments[1];
  save_ply_seeds();
  save_draco_seeds();
  save_mesh_seeds();
  save_scan_seeds();
  return failed ? 1 : 0;
}
