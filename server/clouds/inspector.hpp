// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "clouds/cloud_store.hpp"
#include "worker/side_task.hpp"

namespace surfaced {

/// Has every stored cloud read by a child, one after the other, in a thread of its own: the server itself never
/// parses one. What was not inspected when the server ended is inspected by the next one.
class CloudInspector {
 public:
  CloudInspector(CloudStore& clouds, ArtifactStore& artifacts, const SideTask& task)
      : clouds_(clouds), artifacts_(artifacts), task_(task) {}
  ~CloudInspector() { stop(); }
  CloudInspector(const CloudInspector&) = delete;
  CloudInspector& operator=(const CloudInspector&) = delete;

  void start();
  /// A cloud was stored.
  void wake();
  /// Ends the child that may be running.
  void stop();

 private:
  void work();
  /// False if there was nothing to do, or it could not be done now.
  bool inspect_next();
  Result<nlohmann::ordered_json> inspect(const std::string& id);

  CloudStore& clouds_;
  ArtifactStore& artifacts_;
  const SideTask& task_;
  StopSignal stop_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  bool woken_ = false;
  std::thread thread_;
};

}  // namespace surfaced
