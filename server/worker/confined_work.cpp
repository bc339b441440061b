// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/confined_work.hpp"

#include <exception>
#include <iostream>
#include <new>

#include "platform/files.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confinement.hpp"

namespace surfaced {
namespace {

int give_up(const Error& error) {
  std::cerr << "problem " << name_of(error.code) << ": " << error.detail << std::endl;
  tell_server(encode(error));
  return exit_code_of(error.code);
}

}  // namespace

void tell_server(const std::string& message) {
  [[maybe_unused]] const Status ignored = write_all(kMessageDescriptor, as_bytes(message), "tell the server");
}

int run_confined(const std::string& description, const std::function<Status(const AttemptSpec&)>& work) {
  const auto spec = decode_attempt(description);
  if (!spec) {
    std::cerr << spec.error().detail << "\n";
    return exit_code_of(spec.error().code);
  }
  try {
    const auto confined = confine_this_process(*spec);
    if (!confined) return give_up(confined.error());
    std::cerr << "confined by " << *confined << std::endl;
    if (!spec->traceparent.empty()) std::cerr << "traceparent " << spec->traceparent << std::endl;
    const Status done = work(*spec);
    return done ? 0 : give_up(done.error());
  } catch (const std::bad_alloc&) {
    return give_up({ErrorCode::out_of_memory,
                    "an allocation failed; the limit is " + std::to_string(spec->limits.memory_bytes) + " bytes"});
  } catch (const std::exception& failure) {
    return give_up({ErrorCode::internal_error, failure.what()});
  }
}

}  // namespace surfaced
