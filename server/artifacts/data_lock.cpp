#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

#include "artifacts/file_artifact_store.hpp"
#include "platform/files.hpp"

namespace surfaced {

Result<DataLock> DataLock::acquire(const std::filesystem::path& directory) {
  if (Status made = make_directory(directory); !made.ok()) return made.error();
  UniqueFd fd(::open((directory / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return system_error("open the lock in " + directory.string(), errno);
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return system_error("lock " + directory.string(), errno);
    return Error{ErrorCode::invalid_usage,
                 "--data " + directory.string() + " is in use by another surfaced; stop it or give another directory"};
  }
  return DataLock(std::move(fd));
}

}  // namespace surfaced
