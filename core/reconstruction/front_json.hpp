// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what the methods that grow a front have in common on the façade.
#pragma once

#include "front/statistics.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

Json statistics_json(const front::Statistics& statistics);

/// Whether the method counted its open edges, and there are none.
bool is_known_closed(const Reconstruction& result);

/// Schema of the parameter `max_edge`, with what `auto` means as the last sentence of its text.
Json max_edge_property(const std::string& meaning_of_auto);

}  // namespace surfaced
