// SPDX-License-Identifier: GPL-3.0-or-later
// Preloaded into a server: keeps beside its folder what a power cut would leave of it, by the letter of POSIX. A file
// has the bytes that it had when it was last synced, a folder the names that it had then, and nothing else is there.
//
//   SHADOW/lock          held while anything is synced; whoever holds it stops all that could be acknowledged
//   SHADOW/files/KEY     bytes of a file; KEY is its inode and the time of its birth
//   SHADOW/folders/KEY   a line an entry: kind (f or d), KEY, name
//
// No privilege is needed, and no state that a real disk could be in is worse for a program that syncs too little.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>
#include <vector>

namespace {

using Sync = int (*)(int);

/// Empty in any process but the server itself: its children are confined, and sync nothing.
std::string shadow_folder() {
  std::ifstream command("/proc/self/cmdline");
  std::string program;
  std::string verb;
  std::getline(command, program, '\0');
  std::getline(command, verb, '\0');
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment
  const char* const folder = std::getenv("POWER_CUT_SHADOW");
  return verb == "serve" && folder != nullptr ? folder : "";
}

std::string key_of(const struct statx& status) {
  return std::to_string(status.stx_ino) + "-" + std::to_string(status.stx_btime.tv_sec) + "." +
         std::to_string(status.stx_btime.tv_nsec);
}

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::abort();
}

/// Writes it under another name first: a reader without the lock would see all or nothing.
void write_whole(const std::string& path, const std::vector<char>& bytes) {
  const std::string temporary = path + ".new";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file || std::rename(temporary.c_str(), path.c_str()) != 0) fail("power cut: write");
}

void keep_file(const std::string& shadow, int fd, const struct statx& status) {
  // The server may have opened it for writing alone.
  const int reader = ::open(("/proc/self/fd/" + std::to_string(fd)).c_str(), O_RDONLY | O_CLOEXEC);
  if (reader < 0) fail("power cut: open");
  std::vector<char> bytes(status.stx_size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(reader, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (count < 0) fail("power cut: read");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  ::close(reader);
  bytes.resize(done);
  write_whole(shadow + "/files/" + key_of(status), bytes);
}

void keep_folder(const std::string& shadow, int fd, const struct statx& status) {
  const int reader = ::open(("/proc/self/fd/" + std::to_string(fd)).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* const folder = reader < 0 ? nullptr : ::fdopendir(reader);
  if (folder == nullptr) fail("power cut: open a folder");
  std::string lines;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): each folder is read by one thread
  while (const dirent* const entry = ::readdir(folder)) {
    struct statx each {};
    if (entry->d_name[0] == '.' ||
        ::statx(reader, entry->d_name, AT_SYMLINK_NOFOLLOW, STATX_BASIC_STATS | STATX_BTIME, &each) != 0) {
      continue;
    }
    lines += S_ISDIR(each.stx_mode) ? "d " : "f ";
    lines += key_of(each) + " " + entry->d_name + "\n";
  }
  ::closedir(folder);
  write_whole(shadow + "/folders/" + key_of(status), {lines.begin(), lines.end()});
}

int synced(int fd, const char* name) {
  static const std::string kShadow = shadow_folder();
  static std::mutex mutex;
  const auto sync = reinterpret_cast<Sync>(::dlsym(RTLD_NEXT, name));
  if (kShadow.empty()) return sync(fd);
  const std::scoped_lock lock(mutex);
  const int file = ::open((kShadow + "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0 || ::flock(file, LOCK_EX) != 0) fail("power cut: lock");
  const int result = sync(fd);
  const int error = errno;
  struct statx status {};
  if (result == 0 && ::statx(fd, "", AT_EMPTY_PATH, STATX_BASIC_STATS | STATX_BTIME, &status) == 0) {
    if (S_ISREG(status.stx_mode)) keep_file(kShadow, fd, status);
    if (S_ISDIR(status.stx_mode)) keep_folder(kShadow, fd, status);
  }
  ::close(file);
  errno = error;
  return result;
}

}  // namespace

extern "C" int fsync(int fd) { return synced(fd, "fsync"); }
extern "C" int fdatasync(int fd) { return synced(fd, "fdatasync"); }
