// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/side_main.hpp"

#include <fstream>

#include "io/io.hpp"
#include "platform/files.hpp"
#include "reconstruction/reconstruction.hpp"
#include "worker/confined_work.hpp"
#include "worker/side_task.hpp"

namespace surfaced {
namespace {

Status inspect(const AttemptSpec& spec) {
  auto raw = read_cloud(spec.cloud, ReadLimits{spec.limits.max_points}, "the cloud");
  if (!raw) return std::move(raw).error();
  const std::size_t points = raw->size();
  Json attributes = Json::array({"position"});
  if (!raw->normals.empty()) attributes.push_back("normal");
  if (!raw->colors.empty()) attributes.push_back("color");
  const auto cloud = make_cloud(std::move(*raw), 1, Missing::drop);
  if (!cloud) return cloud.error();
  const Bounds bounds = bounds_of(cloud->positions);
  const auto corner = [](const Point3& point) { return Json::array({point[0], point[1], point[2]}); };
  const Json facts{{"points", points},
                   {"distinct_points", cloud->size()},
                   {"bounds", {{"min", corner(bounds.low)}, {"max", corner(bounds.high)}}},
                   {"attributes", attributes},
                   {"warnings", cloud->warnings}};
  return write_file(spec.directory / spec.mesh, as_bytes(facts.dump(-1, ' ', false, Json::error_handler_t::replace)));
}

Status convert(const AttemptSpec& spec) {
  Json report;
  if (std::ifstream extra(spec.directory / kExtraFile); extra) report = Json::parse(extra, nullptr, false);
  // What the first file lost is not lost in this one.
  if (report.is_object() && spec.cloud.filename() == kKeptMesh) report["encoding"] = nullptr;
  const auto mesh = read_mesh(spec.cloud);
  if (!mesh) return mesh.error();
  return write_again(*mesh, spec.directory / spec.mesh, spec.parameters, std::move(report));
}

}  // namespace

int inspect_main(const std::string& description) { return run_confined(description, inspect); }

int convert_main(const std::string& description) { return run_confined(description, convert); }

}  // namespace surfaced
