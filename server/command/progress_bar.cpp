// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/progress_bar.hpp"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace surfaced {
namespace {

constexpr int kWidth = 40;

void draw(double fraction, std::string_view stage) {
  const int filled = static_cast<int>(fraction * kWidth);
  std::string line = "\r[";
  for (int i = 0; i < kWidth; ++i) line += i < filled ? '#' : '.';
  line += "] " + std::to_string(static_cast<int>(fraction * 100)) + " % " + std::string(stage) + "\x1b[K";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

Context::Sink progress_bar() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return draw;
}

void clear_progress_bar() {
  if (isatty(STDERR_FILENO) != 0) std::fputs("\r\x1b[K", stderr);
}

}  // namespace surfaced
