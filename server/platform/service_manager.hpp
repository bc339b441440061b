// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace surfaced {

/// Tells systemd (or whoever listens on $NOTIFY_SOCKET) how the service is: "READY=1", "STOPPING=1". Does nothing
/// if nobody asked to be told.
void tell_service_manager(std::string_view state);

}  // namespace surfaced
