// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iostream>
#include <span>
#include <string>

#include "command/problem.hpp"
#include "command/usage.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Writes the report to the file, to standard output for "-", or nowhere for an empty name.
/// @return  the exit code.
inline int write_report(const Json& report, const std::string& destination) {
  if (destination.empty()) return 0;
  const std::string text = report.dump(2) + "\n";
  if (destination == "-") {
    std::cout << text << std::flush;
    return std::cout ? 0 : report_problem({ErrorCode::output_not_writable, "standard output cannot be written"});
  }
  const Status written = write_file(destination, std::as_bytes(std::span(text)));
  return written ? 0 : report_file_problem(written.error(), {}, {"--report", destination});
}

}  // namespace surfaced
