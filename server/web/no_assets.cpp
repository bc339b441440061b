// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/assets.hpp"

namespace surfaced::web {

std::span<const Asset> assets() { return {}; }

}  // namespace surfaced::web
