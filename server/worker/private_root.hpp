// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>

namespace surfaced {

/// A place that stays visible, under the same name.
struct VisiblePlace {
  std::filesystem::path path;
  bool writable = false;
};

/// From now on this process and its children have a root directory with nothing in it but these places (those that
/// exist): whatever else there is cannot even be named. For a process with a mount namespace of its own and the power
/// to mount in it.
/// @return  false if the kernel, or who restricts this process, does not let it: then the root is the one it was
bool hide_all_but(std::span<const VisiblePlace> places);

}  // namespace surfaced
