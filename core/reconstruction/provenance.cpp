// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/provenance.hpp"

#include <fcntl.h>
#include <sys/resource.h>

#include "base/sha256.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

std::string_view version() { return SURFACED_VERSION; }

Result<std::string> digest_of(const std::filesystem::path& path) {
  const UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return Error{ErrorCode::input_unreadable, "cannot open " + path.string()};
  auto digest = sha256_of_file(file.get());
  if (!digest) return Error{ErrorCode::input_unreadable, "reading " + path.string() + " failed"};
  return std::move(*digest);
}

Resources resources_used() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  constexpr std::uint64_t kKibibyte = 1024;
  return {.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime),
          .peak_rss_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * kKibibyte};
}

}  // namespace surfaced
