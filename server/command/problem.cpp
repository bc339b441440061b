// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/problem.hpp"

#include <iostream>

#include "proto/embedded.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

int report_problem(const Error& error) {
  // The rows stand in the order of ErrorCode, which is made from the same file.
  const Json row = Json::parse(proto::errors_json()).at("errors").at(static_cast<std::size_t>(error.code));
  const Json problem{
      {"code", name_of(error.code)}, {"title", row.at("title")}, {"detail", error.detail}, {"hint", row.at("hint")}};
  std::cerr << problem.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
  return exit_code_of(error.code);
}

}  // namespace surfaced
