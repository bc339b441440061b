// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/front_json.hpp"

namespace surfaced {

Json statistics_json(const front::Statistics& s) {
  return Json{{"agreed_faces", s.agreed_faces},
              {"one_sided_faces", s.one_sided_faces},
              {"seeds", s.seeds},
              {"sewn_faces", s.sewn_faces},
              {"holes_closed", s.holes_closed},
              {"holes_repaired", s.holes_repaired},
              {"points_inserted", s.points_inserted},
              {"separated_faces", s.separated_faces},
              {"open_edges", s.open_edges}};
}

bool is_known_closed(const Reconstruction& result) {
  return result.statistics.is_object() && result.statistics.value("open_edges", Json(nullptr)) == 0;
}

Json max_edge_property(const std::string& meaning_of_auto) {
  return {{"oneOf", {Json{{"const", "auto"}}, Json{{"type", "number"}, {"minimum", 1}, {"maximum", 1e6}}}},
          {"default", "auto"},
          {"title", "Longest edge"},
          {"description", "In multiples of the distance to the 6th nearest neighbour; about 3 keeps openings open. " +
                              meaning_of_auto},
          {"x-unit", "1"}};
}

}  // namespace surfaced
