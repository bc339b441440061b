// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/upsampling_stage.hpp"

#include <new>
#include <optional>

#include "intrinsic_delaunay/upsampling.hpp"

namespace surfaced {
namespace {

Json statistics_json(const idt::UpsamplingStatistics& s) {
  return Json{
      {"epsilon", s.epsilon}, {"rounds", s.rounds}, {"points_added", s.points_added}, {"from_patches", s.from_patches}};
}

}  // namespace

Json upsample_property() {
  return {
      {"enum", {"none", "jet", "paper"}},
      {"default", "none"},
      {"title", "Points added where triangles are larger than the sampling radius"},
      {"description",
       "jet puts them onto quadrics through their neighbours; paper takes them from the most similar patch elsewhere "
       "where one fits. auto for epsilon is then the distance to the 6th nearest neighbour that 95 % of the points "
       "keep below."}};
}

void count_large_triangles(Reconstruction& made) {
  Json& statistics = made.statistics["upsampling"];
  if (statistics.is_null()) return;
  const Json& epsilon = statistics.at("epsilon");
  const std::size_t large = idt::large_triangles(made.mesh, epsilon.get<double>());
  statistics["large_triangles"] = large;
  if (large == 0) return;
  made.warnings.push_back(std::to_string(large) + " triangles are still larger than the sampling radius " +
                          epsilon.dump());
}

Result<IntrinsicDelaunayResult> reconstruct_upsampled(const PointCloud& cloud, IntrinsicDelaunayParameters method,
                                                      const Json& parameters, Json& statistics, Context& context) {
  const Json& way = parameters.at("upsample");
  if (way == "none") return intrinsic_delaunay(cloud, method, context);
  const std::optional<double> given = method.epsilon;
  method.epsilon = std::nullopt;
  std::optional<IntrinsicDelaunayResult> last;
  const auto reconstruct = [&](const PointCloud& points) -> Result<TriangleMesh> {
    Result<IntrinsicDelaunayResult> result = intrinsic_delaunay(points, method, context);
    if (!result) return std::move(result).error();
    last = std::move(*result);
    return last->mesh;
  };
  try {
    Result<TriangleMesh> mesh = reconstruct(cloud);
    if (!mesh) return std::move(mesh).error();
    context.enter("upsampling", 1);
    const double epsilon = given ? *given : idt::automatic_epsilon(cloud, context);
    Result<idt::Upsampled> result =
        idt::upsample(cloud, std::move(*mesh), epsilon, way == "paper" ? idt::Upsampling::paper : idt::Upsampling::jet,
                      reconstruct, context);
    if (!result) return std::move(result).error();
    statistics = statistics_json(result->statistics);
    last->mesh = std::move(result->mesh);
    return std::move(*last);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "no memory left to upsample " + std::to_string(cloud.size()) + " points"};
  }
}

}  // namespace surfaced
