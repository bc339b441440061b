// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/geometry_case.hpp"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <iterator>

#include "geometry/shapes.hpp"

namespace surfaced::testing {
namespace {

void demand(bool holds, const std::string& claim, const std::string& what) {
  if (holds) return;
  std::cerr << "does not hold: " << claim << ": " << what << std::endl;
  std::abort();
}

/// Where a shape goes: scaled, moved, flattened, turned and shaken.
class Placing {
 public:
  Placing(Choices& choices, Numbers& numbers) : numbers_(numbers) {
    constexpr int kExponents[] = {0, 0, 0, 0, 10, -10, 60, -60, 100, -100, 120, 127, -126, -140, -500, -1040};
    constexpr double kSizes[] = {1, 1, 1, 1, 1e-9, 1e-16, 1e-100, 1e-300};
    constexpr double kOffsets[] = {0, 0, 0, 0, 1, 1e3, 1e6, 1e16};
    constexpr double kShakes[] = {0, 0, 0, 1e-16, 1e-12, 1e-6, 1e-3, 0.1};
    constexpr double kFlat[] = {1, 1, 1, 1, 1, 0, 1e-9, 1e-17};
    exponent_ = choices.one_of(kExponents);
    size_ = choices.one_of(kSizes);
    offset_ = choices.one_of(kOffsets);
    shake_ = choices.one_of(kShakes);
    flat_ = choices.one_of(kFlat);
    if (choices.chance(96)) axis_ = direction_of(shapes::in_cube(numbers_));
    narrow_ = choices.chance(128);
  }

  Point3 operator()(Point3 p) {
    p[2] *= flat_;
    if (axis_) p = turned(p, *axis_, 0.6, 0.8);
    p = size_ * p + shake_ * shapes::in_cube(numbers_) + Point3{offset_, offset_, offset_};
    for (double& x : p) {
      x = std::ldexp(x, exponent_);
      if (narrow_) x = static_cast<double>(static_cast<float>(x));
    }
    return p;
  }

 private:
  Numbers& numbers_;
  int exponent_ = 0;
  double size_ = 1;
  double offset_ = 0;
  double shake_ = 0;
  double flat_ = 1;
  std::optional<Point3> axis_;
  bool narrow_ = false;
};

std::size_t number_of_points(Choices& choices, std::size_t most) {
  const std::size_t bands[] = {4, 12, 12, 60, 60, most};
  return 1 + choices.below(std::min(choices.one_of(bands), most));
}

void add_part(RawCloud& cloud, Choices& choices, std::size_t most) {
  const std::size_t n = number_of_points(choices, most);
  Numbers numbers(choices.word());
  if (choices.chance(16)) {
    // Coordinates as the bytes have them, for the fuzzer to play with.
    for (std::size_t i = 0; i < std::min<std::size_t>(n, 40); ++i) {
      cloud.positions.push_back({choices.real(), choices.real(), choices.real()});
    }
    return;
  }
  const shapes::Points points = shapes::kAll.at(choices.below(shapes::kAll.size()))(n, numbers);
  Placing place(choices, numbers);
  std::ranges::transform(points, std::back_inserter(cloud.positions), place);
}

void add_attributes(RawCloud& cloud, Choices& choices) {
  const std::size_t normals = choices.below(6);
  Numbers numbers(choices.word());
  for (const Point3& p : cloud.positions) {
    const Point3 n = normals == 1 ? p : normals == 2 ? shapes::in_cube(numbers) : Point3{0, 0, 1};
    if (normals >= 1 && normals <= 3) {
      cloud.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
    }
  }
  if (!choices.chance(64)) return;
  while (cloud.colors.size() < cloud.positions.size()) {
    cloud.colors.push_back({static_cast<std::uint8_t>(numbers.below(256)), 100, 200, 255});
  }
}

RawCloud cloud_of(Choices& choices, std::size_t most) {
  RawCloud cloud;
  for (std::size_t parts = 1 + choices.below(4) / 2 + choices.below(4) / 3; parts > 0; --parts) {
    add_part(cloud, choices, most);
  }
  cloud.positions.resize(std::min(cloud.positions.size(), most));
  add_attributes(cloud, choices);
  return cloud;
}

/// A number within the bounds of a schema; often the bounds themselves.
Json number_of(const Json& schema, Choices& choices) {
  const bool whole = schema.at("type") == "integer";
  const bool open = schema.contains("exclusiveMinimum");
  const double low = open ? schema.at("exclusiveMinimum").get<double>() : schema.value("minimum", -1e9);
  const double high = schema.value("maximum", std::max(1e9, 2 * low));
  const double share = static_cast<double>(choices.byte()) / 255;
  double value = low;
  switch (choices.below(6)) {
    case 0:
      break;
    case 1:
      value = high;
      break;
    case 2:  // as many of the small as of the large
      value = low + std::exp2(-40 * (1 - share)) * (high - low);
      break;
    case 3:
      value = low + share;
      break;
    case 4:
      value = low + 8 * share * share;
      break;
    default:
      value = low + share * (high - low);
  }
  if (whole) value = std::floor(value);
  value = std::clamp(value, low, high);
  if (open && value <= low) value = std::min(high, low + 0.25);
  return whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
}

Json value_of(const Json& schema, Choices& choices) {
  if (schema.contains("oneOf"))
    return value_of(schema.at("oneOf").at(choices.below(schema.at("oneOf").size())), choices);
  if (schema.contains("const")) return schema.at("const");
  if (schema.contains("enum")) return schema.at("enum").at(choices.below(schema.at("enum").size()));
  if (schema.at("type") == "boolean") return choices.chance(128);
  if (schema.at("type") == "string")
    return schema.contains("examples") ? schema.at("examples").at(0) : schema.at("default");
  return number_of(schema, choices);
}

Json parameters_of(const MethodInfo& method, Choices& choices) {
  // Often none, so that the method itself is reached; else some.
  constexpr unsigned kShares[] = {0, 16, 48, 128};
  const unsigned share = choices.one_of(kShares);
  Json given = Json::object();
  for (const auto& [name, schema] : method.parameters.at("properties").items()) {
    if (choices.chance(share)) given[name] = value_of(schema, choices);
  }
  Result<Json> checked = check_parameters(method, given);
  demand(checked.ok(), "a value of its schema is a parameter", given.dump());
  return std::move(*checked);
}

void check_refusal(const Error& error) {
  demand(!error.detail.empty() && error.detail.size() < 4096, "a refusal has a message of sensible length",
         error.detail);
  demand(error.code != ErrorCode::internal_error, "geometry never causes an internal error", error.detail);
  for (const char* const inner : {"/CGAL/", ".h", "CGAL ERROR", "Expr:", "assertion"}) {
    demand(error.detail.find(inner) == std::string::npos, "a refusal shows nothing of the library", error.detail);
  }
}

void check_mesh(const std::filesystem::path& file, const std::string& report) {
  const Result<TriangleMesh> mesh = read_mesh(file);
  demand(mesh.ok(), "a mesh that was written can be read", mesh.ok() ? "" : mesh.error().detail);
  // An STL has no vertices: what has no area there is no triangle.
  demand(!mesh->triangles.empty() || file.extension() == ".stl", "a mesh that was written has a triangle", report);
  for (const Triangle& t : mesh->triangles) {
    demand(std::ranges::all_of(t, [&](VertexIndex v) { return v < mesh->positions.size(); }),
           "every corner is a vertex", report);
  }
}

}  // namespace

std::string GeometryCase::text() const {
  Json chosen = Json::object();
  const Json& properties = method->parameters.at("properties");
  for (const auto& [name, value] : parameters.items()) {
    if (value != properties.at(name).at("default")) chosen[name] = value;
  }
  return method->id + " " + extension + ", " + std::to_string(cloud.size()) + " points" +
         (cloud.normals.empty() ? "" : " with normals") + ", " + chosen.dump();
}

GeometryCase geometry_case(std::span<const std::uint8_t> bytes, std::size_t most_points) {
  constexpr const char* kExtensions[] = {".glb", ".glb", ".ply", ".drc", ".obj", ".stl", ".3mf", ".gltf"};
  Choices choices(bytes);
  GeometryCase made;
  made.method = &methods()[choices.below(methods().size())];
  made.extension = choices.one_of(kExtensions);
  made.parameters = parameters_of(*made.method, choices);
  made.cloud = cloud_of(choices, most_points);
  return made;
}

GeometryCase geometry_case(std::uint64_t number, std::size_t most_points) {
  Numbers numbers(number);
  std::array<std::uint8_t, 1024> bytes{};
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(numbers.word() >> 56U);
  return geometry_case(bytes, most_points);
}

std::string run_case(const GeometryCase& geometry, const std::filesystem::path& folder) {
  const std::filesystem::path input = folder / "cloud.ply";
  const std::filesystem::path output = folder / ("mesh" + geometry.extension);
  const Status written =
      write_file(input, encode_cloud_ply(geometry.cloud.positions, geometry.cloud.normals, geometry.cloud.colors));
  demand(written.ok(), "a cloud can be written", written.ok() ? "" : written.error().detail);
  Context context;
  const FileRequest request{.cloud = input,
                            .mesh = output,
                            .method = geometry.method,
                            .parameters = geometry.parameters,
                            .limits = {},
                            .cloud_name = "the cloud"};
  const Result<Json> report = reconstruct_file(request, context);
  if (!report) {
    check_refusal(report.error());
    return std::string(name_of(report.error().code));
  }
  check_mesh(output, report->dump());
  return "done";
}

}  // namespace surfaced::testing
