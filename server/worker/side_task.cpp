// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/side_task.hpp"

#include <unistd.h>

#include <array>

#include "io/io.hpp"
#include "platform/files.hpp"

namespace surfaced {

Result<Output> SideTask::run(const Order& order, const StopSignal& stop) const {
  // What a server that died here has left.
  artifacts_.discard(order.place);
  const auto directory = artifacts_.begin_attempt(order.place);
  if (!directory) return directory.error();
  if (!order.extra.empty()) {
    if (Status written = write_file(*directory / kExtraFile, as_bytes(order.extra)); !written.ok()) {
      artifacts_.discard(order.place);
      return written.error();
    }
  }
  auto log = AttemptLog::create(*directory / "log.txt");
  if (!log) return log.error();
  AttemptSpec spec{order.place,  "", order.parameters, order.input, "", *directory,
                   order.output, "", limits_,          ::getpid()};
  // Nobody counts how often a server has died at it: clouds are read again at every start.
  spec.guarded = true;
  const AttemptResult result = runner_.run(spec, stop, *log, [](double, std::string_view) {});
  if (result.outcome != Outcome::done) {
    artifacts_.discard(order.place);
    return result.error.value_or(Error{ErrorCode::internal_error, "a process of the server failed without a reason"});
  }
  const auto published = artifacts_.publish(order.place, std::array{order.output});
  if (published && published->size() == 1) return published->front();
  artifacts_.discard(order.place);
  if (!published) return published.error();
  return Error{ErrorCode::crashed, "the process ended without writing " + order.output};
}

}  // namespace surfaced
