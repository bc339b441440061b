// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a mesh or a cloud as PNG: draw FILE OUT.png [--size N] [--view AZIMUTH,ELEVATION] [--up y|z] [--wire]
// Grey outside, orange inside; magenta borders, green edges with more than two triangles. Degrees; 0,0 looks along -x.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <numbers>
#include <string>

#include "base/vectors.hpp"
#include "figures/canvas.hpp"
#include "io/io.hpp"

namespace surfaced::figures {
namespace {

constexpr Colour kOutside{0.72, 0.75, 0.82};
constexpr Colour kInside{0.85, 0.42, 0.2};
constexpr Colour kWire{0.2, 0.21, 0.25};
constexpr Colour kBorder{0.85, 0.05, 0.75};
constexpr Colour kCrowded{0.05, 0.6, 0.1};
constexpr double kAmbient = 0.3;
/// Share of the picture that the bounding sphere takes.
constexpr double kFilled = 0.96;

struct Options {
  std::string file;
  std::string picture;
  std::size_t size = 300;
  double azimuth = 35;
  double elevation = 20;
  bool z_up = false;
  bool wire = false;
};

/// Where points come to lie in the picture.
class Camera {
 public:
  Camera(const Options& options, const std::vector<Point3>& points) : size_(static_cast<double>(options.size)) {
    const double azimuth = options.azimuth * std::numbers::pi / 180;
    const double elevation = options.elevation * std::numbers::pi / 180;
    const Point3 up = options.z_up ? Point3{0, 0, 1} : Point3{0, 1, 0};
    const Point3 ahead = options.z_up ? Point3{1, 0, 0} : Point3{0, 0, 1};
    const Point3 level = std::cos(azimuth) * ahead + std::sin(azimuth) * cross(up, ahead);
    to_viewer_ = std::cos(elevation) * level + std::sin(elevation) * up;
    right_ = cross(up, level);
    down_ = cross(right_, to_viewer_);
    const Bounds bounds = bounds_of(points);
    centre_ = 0.5 * (bounds.low + bounds.high);
    double reach = 0;
    for (const Point3& p : points)
      reach = std::max({reach, std::abs(dot(right_, p - centre_)), std::abs(dot(down_, p - centre_))});
    scale_ = reach > 0 ? kFilled * size_ / (2 * reach) : 1;
  }

  ScreenPoint operator()(const Point3& p) const {
    const Point3 d = p - centre_;
    return {size_ / 2 + scale_ * dot(right_, d), size_ / 2 + scale_ * dot(down_, d), scale_ * dot(to_viewer_, d)};
  }
  const Point3& to_viewer() const { return to_viewer_; }
  /// From over the viewer's left shoulder.
  Point3 to_light() const { return *direction_of(to_viewer_ + (-0.5) * right_ + (-0.7) * down_); }

 private:
  double size_;
  double scale_ = 1;
  Point3 centre_{};
  Point3 to_viewer_{};
  Point3 right_{};
  Point3 down_{};
};

Colour shaded(const Colour& colour, double share) {
  Colour result = colour;
  for (double& part : result) part *= kAmbient + (1 - kAmbient) * share;
  return result;
}

void draw_triangles(Canvas& canvas, const Camera& camera, const TriangleMesh& mesh) {
  for (const Triangle& t : mesh.triangles) {
    const Point3& a = mesh.positions[t[0]];
    const auto normal = direction_of(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    if (!normal) continue;
    const bool outside = dot(*normal, camera.to_viewer()) >= 0;
    const double light = (outside ? 1 : -1) * dot(*normal, camera.to_light());
    canvas.triangle({camera(a), camera(mesh.positions[t[1]]), camera(mesh.positions[t[2]])},
                    shaded(outside ? kOutside : kInside, std::max(0.0, light)));
  }
}

/// The two ends of every edge of every triangle, the smaller first, sorted.
std::vector<std::array<std::size_t, 2>> sorted_edges(const TriangleMesh& mesh) {
  std::vector<std::array<std::size_t, 2>> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = t[k];
      const std::size_t b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::ranges::sort(edges);
  return edges;
}

void draw_edges(Canvas& canvas, const Camera& camera, const TriangleMesh& mesh, bool wire) {
  const auto edges = sorted_edges(mesh);
  for (auto at = edges.begin(); at != edges.end();) {
    const auto next = std::upper_bound(at, edges.end(), *at);
    const ScreenPoint from = camera(mesh.positions[(*at)[0]]);
    const ScreenPoint to = camera(mesh.positions[(*at)[1]]);
    const auto triangles = next - at;
    if (triangles == 1) canvas.line(from, to, 2.0, 1.5, kBorder);
    if (triangles > 2) canvas.line(from, to, 1.5, 1.5, kCrowded);
    if (triangles == 2 && wire) canvas.line(from, to, 0.6, 0.7, kWire);
    at = next;
  }
}

/// Nearer points are darker and larger.
void draw_points(Canvas& canvas, const Camera& camera, const std::vector<Point3>& points, double size) {
  for (const Point3& p : points) {
    const ScreenPoint at = camera(p);
    const double near = std::clamp(at.z / size + 0.5, 0.0, 1.0);
    canvas.dot(at, 0.6 + 0.7 * near, Colour{0.75 - 0.6 * near, 0.78 - 0.58 * near, 0.85 - 0.5 * near});
  }
}

bool read_number(std::string_view text, auto& number) {
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failed == std::errc() && end == text.data() + text.size();
}

bool read_option(Options& options, std::string_view name, std::string_view value) {
  if (name == "--size") return read_number(value, options.size) && options.size > 0 && options.size <= 4096;
  if (name == "--up") {
    options.z_up = value == "z";
    return value == "y" || value == "z";
  }
  const std::size_t comma = value.find(',');
  return name == "--view" && comma != value.npos && read_number(value.substr(0, comma), options.azimuth) &&
         read_number(value.substr(comma + 1), options.elevation);
}

bool read_options(Options& options, const std::vector<std::string>& words) {
  if (words.size() < 2) return false;
  options.file = words[0];
  options.picture = words[1];
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (words[i] == "--wire") {
      options.wire = true;
    } else if (i + 1 == words.size() || !read_option(options, words[i], words[i + 1])) {
      return false;
    } else {
      ++i;
    }
  }
  return true;
}

int draw(const Options& options) {
  auto mesh = read_mesh(options.file);
  if (mesh && mesh->triangles.empty()) mesh = Error{ErrorCode::method_failed, ""};
  const auto cloud = mesh ? Result<RawCloud>(RawCloud{}) : read_cloud(options.file);
  if (!cloud) {
    std::cerr << "draw: " << cloud.error().detail << "\n";
    return 1;
  }
  const std::vector<Point3>& points = mesh ? mesh->positions : cloud->positions;
  const Camera camera(options, points);
  Canvas canvas(options.size);
  if (mesh) {
    draw_triangles(canvas, camera, *mesh);
    draw_edges(canvas, camera, *mesh, options.wire);
  } else {
    draw_points(canvas, camera, points, static_cast<double>(options.size));
  }
  if (canvas.write_png(options.picture)) return 0;
  std::cerr << "draw: " << options.picture << " cannot be written\n";
  return 1;
}

}  // namespace
}  // namespace surfaced::figures

int main(int argc, char** argv) {
  surfaced::figures::Options options;
  if (surfaced::figures::read_options(options, {argv + 1, argv + argc})) return surfaced::figures::draw(options);
  std::cerr << "usage: draw FILE OUT.png [--size 1..4096] [--view AZIMUTH,ELEVATION] [--up y|z] [--wire]\n";
  return 2;
}
