// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace surfaced {

/// Wakes those who wait for a job in this process. It only says that something changed; what, the
/// store knows. A waiter subscribes before it looks at the job, so that no change falls between.
class JobEvents {
 public:
  /// Calls the function at every change of the job, on the thread that made it, until the returned object is gone;
  /// afterwards no call is running any more. The function must not call back. To be gone before this object.
  std::shared_ptr<void> subscribe(std::string_view job, std::function<void()> wake);

  void changed(std::string_view job);

 private:
  std::mutex mutex_;
  std::multimap<std::string, std::function<void()>, std::less<>> waiters_;
};

}  // namespace surfaced
