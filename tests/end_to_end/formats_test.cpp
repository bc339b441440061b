// SPDX-License-Identifier: GPL-3.0-or-later
// Every format out, through the command and through HTTP: the same bytes, and what became of the coordinates.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "io/io.hpp"
#include "support/codes.hpp"
#include "support/glb_files.hpp"
#include "support/scan_files.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using testing::Answer;
namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kFormats{"glb", "gltf", "drc", "ply", "obj", "stl", "3mf"};

std::string read_all(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

class FormatsEndToEnd : public ::testing::Test {
 protected:
  void SetUp() override { server_.emplace(directory_.path() / "data"); }

  /// The mesh that the command makes of a cloud.
  std::string by_command(const fs::path& cloud, const std::string& format, const std::string& flags) const {
    const fs::path mesh = directory_.path() / ("mesh." + format);
    const std::string line = std::string("'") + SURFACED_BINARY + "' reconstruct '" + cloud.string() + "' -o '" +
                             mesh.string() + "' --method advancing-front " + flags;
    EXPECT_EQ(std::system(line.c_str()), 0) << line;
    return read_all(mesh);
  }

  /// A finished job of a cloud.
  std::string job_of(const std::string& cloud, const std::string& query) const {
    const Answer answer = testing::call(server_->port(), "POST", "/v1/jobs?method=advancing-front" + query, cloud);
    EXPECT_EQ(answer.status, 201) << answer.body;
    const std::string id = Json::parse(answer.body).at("id");
    const Json ended = testing::wait_for_end(server_->port(), id);
    EXPECT_EQ(ended.at("status"), "successful") << ended.dump();
    return id;
  }

  std::string by_http(const std::string& id, const std::string& format) const {
    const Answer answer = testing::call(server_->port(), "GET", "/v1/jobs/" + id + "/outputs/mesh." + format, {}, {});
    EXPECT_EQ(answer.status, 200) << format << ": " << answer.body;
    return answer.body;
  }

  testing::TemporaryDirectory directory_;
  std::optional<testing::ServerProcess> server_;
};

TEST_F(FormatsEndToEnd, a_real_cloud_gives_the_same_mesh_in_every_format_by_command_and_over_http) {
  const fs::path cloud = fs::path(SURFACED_SHARED_DATA) / "fertility.ply";
  if (!fs::exists(cloud)) GTEST_SKIP() << "./dev data fetches its cloud";
  const std::string id = job_of(read_all(cloud), "");
  for (const std::string format : kFormats) {
    const std::string ours = by_command(cloud, format, "");
    const std::string theirs = by_http(id, format);
    EXPECT_TRUE(ours == theirs) << format << ": " << ours.size() << " and " << theirs.size();
    const auto mesh = decode_mesh(bytes_of(theirs), "mesh");
    ASSERT_TRUE(mesh) << format << ": " << testing::detail_of(mesh);
    const Topology topology = topology_of(*mesh);
    EXPECT_EQ(topology.vertices, 4494U) << format;
    EXPECT_TRUE(topology.oriented) << format;
  }
}

/// A cloud of doubles with normals and colours, as a PLY.
std::string painted_sphere() {
  std::ostringstream text;
  text.precision(17);
  const std::vector<Point3> points = testing::sphere_points(300, {0, 0, 0}, 1);
  text << "ply\nformat ascii 1.0\nelement vertex " << points.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty "
          "float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point3& p = points[i];
    text << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << i % 251 << ' '
         << i % 13 << " 200\n";
  }
  return text.str();
}

/// Whether a glTF says the same apart from the text of its report.
bool same_mesh(const std::string& ours, const std::string& theirs, const std::string& format) {
  if (format != "glb" && format != "gltf") return ours == theirs;
  const auto a = decode_mesh(bytes_of(ours), "ours");
  const auto b = decode_mesh(bytes_of(theirs), "theirs");
  return a && b && a->positions == b->positions && a->triangles == b->triangles && a->normals == b->normals &&
         a->colors == b->colors;
}

TEST_F(FormatsEndToEnd, no_format_is_made_of_another_that_has_lost_something) {
  const std::string painted = painted_sphere();
  const fs::path cloud = directory_.path() / "painted.ply";
  ASSERT_TRUE(write_file(cloud, bytes_of(painted)));
  for (const std::string first : {"stl", "drc&quantization=9"}) {
    const std::string asked =
        job_of(painted, "&outputs=mesh." + first.substr(0, 3) + ",mesh.glb,mesh.obj" + first.substr(3));
    const std::string later = job_of(painted, "&outputs=mesh." + first);
    for (const std::string format : {"glb", "ply", "obj"}) {
      const std::string direct = by_command(cloud, format, "");
      EXPECT_TRUE(same_mesh(by_http(asked, format), direct, format)) << format << " beside " << first;
      EXPECT_TRUE(same_mesh(by_http(later, format), direct, format)) << format << " after " << first;
    }
    const Json job = testing::job_of(server_->port(), later);
    EXPECT_EQ(job.dump().find("kept"), std::string::npos) << job.dump();
    EXPECT_EQ(testing::call(server_->port(), "GET", "/v1/jobs/" + later + "/outputs/kept.ply", {}, {}).status, 404);
  }
}

/// Where a scan in a national grid may lie; millimetres in LAS are exact decimals there, not exact doubles.
constexpr Point3 kFar{1412345.678, 5654321.123, 123.456};
constexpr double kMillimetre = 0.001;

struct GeoreferencedScan {
  std::string las;
  std::vector<Point3> points;
};

GeoreferencedScan georeferenced_sphere() {
  const testing::LasOptions options{
      .minor = 4, .format = 6, .scale = {kMillimetre, kMillimetre, kMillimetre}, .offset = {1400000, 5600000, 0}};
  GeoreferencedScan scan;
  std::vector<testing::LasPoint> records;
  for (const Point3& p : testing::sphere_points(400, {0, 0, 0}, 5)) {
    testing::LasPoint& record = records.emplace_back();
    Point3& point = scan.points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double steps = std::round((kFar[axis] + p[axis] - options.offset[axis]) / kMillimetre);
      record.xyz.at(axis) = static_cast<std::int32_t>(steps);
      point[axis] = steps * kMillimetre + options.offset.at(axis);
    }
  }
  scan.las = testing::las_file(records, options);
  return scan;
}

/// The greatest distance of a vertex from the point that it is.
double greatest_error(const TriangleMesh& mesh, const std::vector<Point3>& points) {
  double worst = 0;
  for (const Point3& v : mesh.positions) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point3& p : points) nearest = std::min(nearest, norm(v - p));
    worst = std::max(worst, nearest);
  }
  return worst;
}

TEST_F(FormatsEndToEnd, a_georeferenced_las_keeps_its_millimetres_in_every_format) {
  const GeoreferencedScan scan = georeferenced_sphere();
  const fs::path cloud = directory_.path() / "scan.las";
  ASSERT_TRUE(write_file(cloud, bytes_of(scan.las)));
  const std::string id = job_of(scan.las, "&unit=m");
  for (const std::string format : kFormats) {
    for (const std::string& text : {by_command(cloud, format, "--param unit=m"), by_http(id, format)}) {
      const auto mesh = decode_mesh(bytes_of(text), "mesh");
      ASSERT_TRUE(mesh) << format << ": " << testing::detail_of(mesh);
      EXPECT_LT(greatest_error(*mesh, scan.points), 1e-6) << format;
    }
    const bool keeps_doubles = format == "ply" || format == "drc" || format == "obj";
    if (!keeps_doubles) continue;
    const auto mesh = decode_mesh(bytes_of(by_command(cloud, format, "")), "mesh");
    EXPECT_EQ(greatest_error(*mesh, scan.points), 0) << format;
  }
}

TEST_F(FormatsEndToEnd, the_origin_of_a_georeferenced_las_stands_in_the_node_as_translation_and_as_extras) {
  const GeoreferencedScan scan = georeferenced_sphere();
  for (const std::string up : {"y", "z"}) {
    const std::string glb = by_http(job_of(scan.las, "&up=" + up), "glb");
    const std::span<const std::byte> bytes = bytes_of(glb);
    const testing::Json node = testing::take_apart({bytes.begin(), bytes.end()}).json["nodes"][0];
    const auto origin = node["extras"]["origin"].get<std::vector<double>>();
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(origin[axis], kFar[axis], 5);
    const std::vector<double> turned{origin[0], origin[2], -origin[1]};
    EXPECT_EQ(node["translation"].get<std::vector<double>>(), up == "y" ? origin : turned);
    const auto mesh = decode_mesh(bytes, "mesh");
    ASSERT_TRUE(mesh) << testing::detail_of(mesh);
    EXPECT_LT(greatest_error(*mesh, scan.points), 1e-6) << "in the coordinates of the cloud, whatever is up";
  }
}

}  // namespace
}  // namespace surfaced
