// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "base/base.hpp"

namespace surfaced {

/// A sink that draws a progress bar on stderr if that is a terminal, else an empty one.
Context::Sink progress_bar();

/// Wipes the bar, so that what follows starts on a clean line.
void clear_progress_bar();

}  // namespace surfaced
