// SPDX-License-Identifier: GPL-3.0-or-later
// What a child writes to its pipe, and what the command line of an attempt may hold: JSON by whoever.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "worker/attempt_protocol.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace surfaced;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  LineSplitter splitter;
  splitter.add(text, [](std::string_view line) {
    require(line.size() <= kMaxMessageBytes);
    const Message message = decode_message(line);
    if (const auto* progress = std::get_if<ProgressMessage>(&message)) {
      require(progress->progress >= 0 && progress->progress <= 1 && progress->phase.size() <= 64);
    }
    if (const auto* problem = std::get_if<Error>(&message)) require(problem->detail.size() <= 4096);
  });
  if (const auto spec = decode_attempt(text)) require(decode_attempt(encode(*spec)).ok());
  return 0;
}
