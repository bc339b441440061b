// Private to the room: what the methods that grow a front have in common on the façade.
#pragma once

#include "front/statistics.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

Json statistics_json(const front::Statistics& statistics);

/// Schema of the parameter `max_edge`.
Json max_edge_property();

}  // namespace surfaced
