#include "worker/side_main.hpp"

#include <fstream>
#include <iostream>
#include <new>

#include "io/io.hpp"
#include "platform/files.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confinement.hpp"
#include "worker/convert.hpp"
#include "worker/side_task.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

int give_up(const Error& error) {
  // Nobody to tell if this fails: then the server is gone, and its death is this process's.
  [[maybe_unused]] const Status ignored = write_all(kMessageDescriptor, as_bytes(encode(error)), "tell the server");
  return exit_code_of(error.code);
}

/// What every child does around its work.
template <class Work>
int confined(const std::string& description, const Work& work) {
  const auto spec = decode_attempt(description);
  if (!spec) {
    std::cerr << spec.error().detail << "\n";
    return exit_code_of(spec.error().code);
  }
  try {
    const auto how = confine_this_process(*spec);
    if (!how) return give_up(how.error());
    const Status done = work(*spec);
    return done ? 0 : give_up(done.error());
  } catch (const std::bad_alloc&) {
    return give_up({ErrorCode::out_of_memory,
                    "an allocation failed; the limit is " + std::to_string(spec->limits.memory_bytes) + " bytes"});
  } catch (const std::exception& failure) {
    return give_up({ErrorCode::internal_error, failure.what()});
  }
}

Status inspect(const AttemptSpec& spec) {
  auto raw = read_cloud(spec.cloud, ReadLimits{spec.limits.max_points}, "the cloud");
  if (!raw) return std::move(raw).error();
  const std::size_t points = raw->size();
  Json attributes = Json::array({"position"});
  if (!raw->normals.empty()) attributes.push_back("normal");
  if (!raw->colors.empty()) attributes.push_back("color");
  const auto cloud = make_cloud(std::move(*raw));
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
  return convert_mesh(spec.cloud, spec.directory / spec.mesh, spec.parameters, std::move(report));
}

}  // namespace

int inspect_main(const std::string& description) { return confined(description, inspect); }

int convert_main(const std::string& description) { return confined(description, convert); }

}  // namespace surfaced
