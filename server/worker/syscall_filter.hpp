// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/base.hpp"

namespace surfaced {

/// From now on this process reads and writes what is open, opens files, manages its memory and its threads,
/// and asks for the time; the lists stand in the source. Needs PR_SET_NO_NEW_PRIVS.
/// @return  not_ready if the kernel takes no filter
Status restrict_system_calls();

}  // namespace surfaced
