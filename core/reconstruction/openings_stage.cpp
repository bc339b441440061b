// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/openings_stage.hpp"

#include <algorithm>

#include "mesh/spanning.hpp"
#include "reconstruction/front_json.hpp"
#include "reconstruction/words.hpp"

namespace surfaced {
namespace {

std::size_t boundary_edges(const TriangleMesh& mesh) {
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  std::size_t count = 0;
  for (std::size_t e = 0; e < half_edges.edges(); ++e) count += half_edges.uses(e) == 1 ? 1U : 0U;
  return count;
}

}  // namespace

Json openings_property() {
  return {{"enum", {"keep", "close"}},
          {"default", "keep"},
          {"title", "What becomes of openings"},
          {"description",
           "keep drops triangles that span an opening about six spacings wide or wider: much larger than all triangles "
           "around them. close leaves them, with a warning."}};
}

void run_openings_parameter(Reconstruction& result, const Json& parameters) {
  const bool keep = parameters.at("openings") == "keep";
  std::vector<SpannedOpening> openings = spanned_openings(result.mesh);
  bool peeled = false;
  if (keep && (!openings.empty() || !is_known_closed(result))) {
    open_up(result.mesh, openings);
    peeled = peel_slivers(result.mesh) > 0;
  }
  if (keep && (peeled || !openings.empty())) {
    orient_outwards(result.mesh);
    if (result.statistics.is_object()) result.statistics["open_edges"] = boundary_edges(result.mesh);
  }
  if (openings.empty()) return;
  double longest = 0;
  for (const SpannedOpening& opening : openings) longest = std::max(longest, opening.longest_edge);
  const std::string count = std::to_string(openings.size()) + (openings.size() == 1 ? " opening " : " openings ");
  result.warnings.push_back(
      count + (keep ? "left open, which edges up to " + briefly(longest) + " long would span; openings=close spans them"
                    : "spanned by edges up to " + briefly(longest) +
                          " long, where the points around are far denser; openings=keep leaves them open"));
}

}  // namespace surfaced
