// SPDX-License-Identifier: GPL-3.0-or-later
// Readers and writers on files of 1 and 10 million points, beside their peers.
//   ./dev bench io
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <tuple>

#include "benchmarks/io_peers.hpp"
#include "io/io.hpp"
#include "support/ply_files.hpp"
#include "support/scan_files.hpp"
#include "support/shapes.hpp"

namespace surfaced::benchmarks {
namespace {

using testing::PlyBuilder;
using testing::PlyForm;
namespace fs = std::filesystem;

/// Files are made when first asked for and removed at the end.
class SampleFiles {
 public:
  SampleFiles() : folder_(fs::temp_directory_path() / ("surfaced_benchmark_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~SampleFiles() { fs::remove_all(folder_); }

  std::string get(PlyForm form, std::size_t points, bool attributes) {
    const auto [known, is_new] = paths_.try_emplace({form, points, attributes});
    if (is_new) known->second = make(form, points, attributes, paths_.size());
    return known->second;
  }

 private:
  std::string make(PlyForm form, std::size_t points, bool attributes, std::size_t number) const {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> coordinate(-1, 1);
    PlyBuilder ply(form);
    ply.element("vertex", points);
    for (const char* name : {"x", "y", "z"}) ply.property("float", name);
    if (attributes) {
      for (const char* name : {"nx", "ny", "nz"}) ply.property("float", name);
      for (const char* name : {"red", "green", "blue"}) ply.property("uchar", name);
    }
    for (std::size_t i = 0; i < points; ++i) {
      for (int k = 0; k < (attributes ? 6 : 3); ++k) ply.value("float", static_cast<double>(coordinate(random)));
      for (int k = 0; k < (attributes ? 3 : 0); ++k) ply.value("uchar", static_cast<double>(i % 256));
      ply.end_row();
    }
    const std::string path = folder_ / (std::to_string(number) + ".ply");
    if (!write_file(path, ply.bytes())) std::abort();
    return path;
  }

  fs::path folder_;
  std::map<std::tuple<PlyForm, std::size_t, bool>, std::string> paths_;
};

SampleFiles& files() {
  static SampleFiles samples;
  return samples;
}

using Reader = std::optional<std::size_t> (*)(const std::string&);

void read(benchmark::State& state, Reader reader, PlyForm form, bool attributes) {
  const auto points = static_cast<std::size_t>(state.range(0));
  const std::string path = files().get(form, points, attributes);
  for ([[maybe_unused]] auto _ : state) {
    if (reader(path) != points) state.SkipWithError("the points were not read");
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(fs::file_size(path)) * state.iterations());
  state.SetItemsProcessed(state.range(0) * state.iterations());
  state.SetComplexityN(state.range(0));
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Arg(1'000'000)->Arg(10'000'000)->Unit(benchmark::kMillisecond)->Complexity(benchmark::oN);
}

BENCHMARK_CAPTURE(read, binary_surfaced, read_with_surfaced, PlyForm::little, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, binary_cgal, read_with_cgal, PlyForm::little, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, binary_draco, read_with_draco, PlyForm::little, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, big_endian_surfaced, read_with_surfaced, PlyForm::big, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, normals_colours_surfaced, read_with_surfaced, PlyForm::little, true)->Apply(sizes);
BENCHMARK_CAPTURE(read, ascii_surfaced, read_with_surfaced, PlyForm::ascii, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, ascii_cgal, read_with_cgal, PlyForm::ascii, false)->Apply(sizes);
BENCHMARK_CAPTURE(read, ascii_draco, read_with_draco, PlyForm::ascii, false)->Apply(sizes);

/// Text of a file of `points` points (STL: facets) in a format of other programs.
std::string other_format(std::string_view format, std::size_t points) {
  if (format == "las") {
    std::vector<testing::LasPoint> records(points);
    for (std::size_t i = 0; i < points; ++i) {
      const auto n = static_cast<std::int32_t>(i);
      records[i] = {{n, n * 7 % 1000, -n}, {static_cast<std::uint16_t>(i), 7, 9}};
    }
    return testing::las_file(records);
  }
  if (format == "stl") return testing::binary_stl(testing::Facets(points, testing::two_facets()[1]));
  if (format.starts_with("glb") || format == "drc") {
    EncodeOptions options;
    if (format == "glb_draco") options.compression = MeshCompression::draco;
    if (format == "glb_meshopt") options.compression = MeshCompression::meshopt;
    const MeshFormat container = format == "drc" ? MeshFormat::drc : MeshFormat::glb;
    const auto bytes = encode_mesh(testing::torus_mesh(points / 500, 500), container, options).value();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  const std::string n = std::to_string(points);
  testing::ByteWriter columns;
  for (std::size_t i = 0; i < 4 * points; ++i) columns.put(static_cast<float>(i * 7 % 1000) / 8);
  const std::string head = "VERSION .7\nFIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH " + n + "\nHEIGHT 1\nDATA ";
  if (format == "pcd") return head + "binary\n" + columns.text;
  if (format == "pcd_compressed") {
    const std::string packed = testing::lzf_of(columns.text);
    testing::ByteWriter sizes;
    sizes.put(static_cast<std::uint32_t>(packed.size())).put(static_cast<std::uint32_t>(columns.text.size()));
    return head + "binary_compressed\n" + sizes.text + packed;
  }
  std::string text;
  for (std::size_t i = 0; i < points; ++i) {
    text += (format == "obj" ? "v " : "") + std::to_string(static_cast<double>(i) / 7) + " " +
            std::to_string(i % 1000) + ".125 -" + std::to_string(i) + ".5\n";
  }
  return text;
}

/// The peer of all readers: the file's bytes, copied into memory that nobody has touched yet.
std::optional<std::size_t> read_plainly(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return std::nullopt;
  std::vector<char> bytes(fs::file_size(path));
  const std::size_t read = std::fread(bytes.data(), 1, bytes.size(), file);
  std::fclose(file);
  return read;
}

void read_other(benchmark::State& state, const char* format, bool plainly) {
  const fs::path path = fs::temp_directory_path() / ("surfaced_benchmark_" + std::to_string(::getpid()) + "." + format);
  const std::string text = other_format(format, static_cast<std::size_t>(state.range(0)));
  if (!write_file(path, std::as_bytes(std::span(text.data(), text.size())))) std::abort();
  for ([[maybe_unused]] auto _ : state) {
    const bool read = plainly ? read_plainly(path) == text.size() : read_cloud(path).ok();
    if (!read) state.SkipWithError("the points were not read");
  }
  state.SetItemsProcessed(state.range(0) * state.iterations());
  state.SetBytesProcessed(static_cast<std::int64_t>(text.size()) * state.iterations());
  fs::remove(path);
}

BENCHMARK_CAPTURE(read_other, plain_copy_of_las, "las", true)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, drc, "drc", false)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, glb_draco, "glb_draco", false)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, glb_meshopt, "glb_meshopt", false)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, las, "las", false)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, pcd_binary, "pcd", false)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, pcd_compressed, "pcd_compressed", false)->Arg(4'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, stl_binary, "stl", false)->Arg(2'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, glb, "glb", false)->Arg(2'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, xyz, "xyz", false)->Arg(2'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_other, obj, "obj", false)->Arg(2'000'000)->Unit(benchmark::kMillisecond);

void encode(benchmark::State& state, MeshFormat format) {
  const TriangleMesh mesh = testing::torus_mesh(static_cast<std::size_t>(state.range(0)), 500);
  std::size_t bytes = 0;
  for ([[maybe_unused]] auto _ : state) bytes = encode_mesh(mesh, format).value().size();
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes) * state.iterations());
  state.SetComplexityN(state.range(0));
}

void decode(benchmark::State& state, MeshFormat format) {
  const TriangleMesh mesh = testing::torus_mesh(static_cast<std::size_t>(state.range(0)), 500);
  const std::vector<std::byte> bytes = encode_mesh(mesh, format).value();
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(decode_mesh(bytes, "mesh").ok());
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes.size()) * state.iterations());
  state.SetComplexityN(state.range(0));
}

void mesh_sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Arg(200)->Arg(2000)->Unit(benchmark::kMillisecond)->Complexity(benchmark::oN);
}

BENCHMARK_CAPTURE(encode, glb, MeshFormat::glb)->Apply(mesh_sizes);
BENCHMARK_CAPTURE(encode, ply, MeshFormat::ply)->Apply(mesh_sizes);
BENCHMARK_CAPTURE(encode, drc, MeshFormat::drc)->Apply(mesh_sizes);
BENCHMARK_CAPTURE(decode, glb, MeshFormat::glb)->Apply(mesh_sizes);
BENCHMARK_CAPTURE(decode, ply, MeshFormat::ply)->Apply(mesh_sizes);
BENCHMARK_CAPTURE(decode, drc, MeshFormat::drc)->Apply(mesh_sizes);

}  // namespace
}  // namespace surfaced::benchmarks

BENCHMARK_MAIN();
