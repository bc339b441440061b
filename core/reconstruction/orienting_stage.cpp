// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/orienting_stage.hpp"

#include <charconv>

#include "mesh/facing.hpp"
#include "reconstruction/front_json.hpp"
#include "reconstruction/reading_stage.hpp"
#include "reconstruction/words.hpp"

namespace surfaced {
namespace {

constexpr std::string_view kViewpoint = "viewpoint=";
constexpr std::size_t kLongestViewpoint = 100;

/// The place in "viewpoint=x,y,z", whose form the schema has checked.
Point3 place_in(std::string_view text) {
  text.remove_prefix(kViewpoint.size());
  Point3 place{};
  for (double& x : place) {
    x = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), x);
    text.remove_prefix(std::min(static_cast<std::size_t>(end - text.data()) + 1, text.size()));
  }
  return place;
}

FacingOptions options_of(const std::string& way, const std::optional<Point3>& sensor) {
  if (way.starts_with(kViewpoint)) return {.rule = FacingRule::viewpoint, .viewpoint = place_in(way)};
  if (way == "up") return {.rule = FacingRule::up};
  if (way == "outwards") return {.rule = FacingRule::outwards};
  return {.rule = way == "flip" ? FacingRule::flip : FacingRule::automatic, .viewpoint = sensor};
}

std::string percent_of(double share) { return briefly(100 * share) + " %"; }

void warn_of_normals(const NormalsUse& normals, std::vector<std::string>& warnings) {
  const std::string agreeing = percent_of(normals.agreeing) + " of the vertices";
  if (2 * normals.computed > normals.vertices) {
    warnings.push_back(
        "normals replaced: most of them lie along the surface rather than across it; those of the mesh are made of its "
        "faces");
  } else if (!normals.trusted) {
    warnings.push_back("normals contradict each other: even at the better side they fit the faces at " + agreeing +
                       " only, so they did not decide which side is the front; " + std::to_string(normals.turned) +
                       " of them were turned to the side of the faces");
  } else if (normals.turned > 0) {
    warnings.push_back(std::to_string(normals.turned) + " of " + std::to_string(normals.vertices) +
                       " normals opposed the faces and were turned around");
  }
}

Json normals_json(const std::optional<NormalsUse>& normals) {
  if (!normals) return nullptr;
  return Json{{"agreeing", normals->agreeing},
              {"trusted", normals->trusted},
              {"turned", normals->turned},
              {"computed", normals->computed}};
}

Json facing_json(const Facing& facing) {
  Json by = Json::object();
  constexpr std::array<const char*, kFacingReasons> kNames{"normals", "viewpoint", "up", "outwards"};
  for (std::size_t i = 0; i < kNames.size(); ++i) by[kNames.at(i)] = facing.triangles.at(i);
  return Json{{"triangles_by", std::move(by)},
              {"certainty", facing.certainty ? Json(*facing.certainty) : Json(nullptr)},
              {"turned_triangles", facing.turned},
              {"normals", normals_json(facing.normals)}};
}

}  // namespace

Json orienting_properties() {
  const std::string number = "-?[0-9]+([.][0-9]*)?([eE]-?[0-9]+)?";
  return Json{{"orient",
               {{"oneOf",
                 {Json{{"enum", {"auto", "up", "outwards", "flip"}}},
                  Json{{"type", "string"},
                       {"pattern", "viewpoint=" + number + "," + number + "," + number},
                       {"maxLength", kLongestViewpoint},
                       {"x-allowed", "viewpoint=x,y,z with three numbers"},
                       {"examples", {"viewpoint=0,0,1.7"}}}}},
                {"default", "auto"},
                {"title", "Front of the surface"},
                {"description",
                 "auto: by the normals of the cloud if four fifths of them agree; else towards the sensor, where the "
                 "file tells where it "
                 "stood; else upwards, if the part is a height field; else outwards. up, outwards and viewpoint=x,y,z "
                 "decide alone; "
                 "flip is the opposite of auto."}}}};
}

void orient(Reconstruction& result, const Json& parameters, const std::optional<Point3>& sensor) {
  const std::string way = parameters.at("orient");
  if (asks_for_mesh(parameters) && way == "auto") return;
  // A closed surface of which nothing else is known faces outwards already.
  const bool nothing_to_decide = way == "auto" && result.mesh.normals.empty() && !sensor && is_known_closed(result);
  const Facing facing = nothing_to_decide ? Facing{.triangles = {0, 0, 0, result.mesh.triangles.size()}}
                                          : face(result.mesh, options_of(way, sensor));
  if (facing.normals) warn_of_normals(*facing.normals, result.warnings);
  result.orientation = facing_json(facing);
}

std::vector<std::string> warnings_of_inward_faces(const Json& volume) {
  if (volume.is_null() || volume >= 0) return {};
  return {"the faces of the closed surface look inwards; orient=outwards turns them around"};
}

}  // namespace surfaced
