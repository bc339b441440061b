// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <seccomp.h>

#include <vector>

namespace surfaced {

/// A system call, with conditions that all its arguments have to meet.
struct SyscallRule {
  const char* name;
  std::vector<scmp_arg_cmp> arguments;
};

/// What an attempt needs: several rules with one name are alternatives. Whatever meets none of them fails with EPERM.
std::vector<SyscallRule> allowed_calls();

/// What only an intruder asks for.
std::vector<SyscallRule> deadly_calls();

}  // namespace surfaced
