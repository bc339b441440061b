// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"

namespace surfaced {

/// Keeps pages of other sites away from a server that asks nobody for a key because only friends can reach it: their
/// browsers can, too, and show pages of strangers.
///
/// - A name that a stranger's DNS may resolve to this machine (rebinding) is no name of this server: taken are
///   localhost, addresses, names without a dot (which nobody outside of this network can own), and those listed.
/// - A page of another site sends `Origin` with whatever changes something, and `Sec-Fetch-Site` with all else.
class BrowserGuard {
 public:
  /// @param hosts    further names of the server; `*` switches the guard off
  /// @param origins  origins of other sites whose pages may call (those of CORS); `*` for all
  BrowserGuard(std::vector<std::string> hosts, std::vector<std::string> origins);

  /// Why the request is not answered: forbidden, with what is allowed.
  std::optional<Error> refuse(const http::Request& request) const;

 private:
  bool is_own(std::string_view name) const;

  std::vector<std::string> hosts_;
  std::vector<std::string> origins_;
};

}  // namespace surfaced
