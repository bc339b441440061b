// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <utility>

namespace surfaced {

/// Calls body(begin, end) for pieces that together cover 0..count-1, on at most `threads` threads.
/// The pieces depend on the machine's load: the body has to be a map whose result does not depend on them.
template <class Body>
void parallel_ranges(unsigned threads, std::size_t count, Body&& body) {
  constexpr std::size_t kGrain = 4096;
  if (threads <= 1 || count <= kGrain) {
    if (count > 0) body(std::size_t{0}, count);
    return;
  }
  tbb::task_arena arena(static_cast<int>(threads));
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
  });
}

/// Calls task(0) .. task(count-1), several at a time on at most `threads` threads.
template <class Task>
void parallel_tasks(unsigned threads, std::size_t count, Task&& task) {
  if (threads <= 1) {
    for (std::size_t k = 0; k < count; ++k) task(k);
    return;
  }
  tbb::task_arena arena(static_cast<int>(threads));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t k = range.begin(); k < range.end(); ++k) task(k);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace surfaced
