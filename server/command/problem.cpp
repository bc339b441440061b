#include "command/problem.hpp"

#include <iostream>

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

int report_problem(const Error& error) {
  const Json problem{{"code", name_of(error.code)}, {"detail", error.detail}};
  std::cerr << problem.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
  return exit_code_of(error.code);
}

}  // namespace surfaced
