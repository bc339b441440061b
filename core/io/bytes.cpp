// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace surfaced::io {
namespace {

/// Small enough that a block and the points made from it stay in the cache.
constexpr std::size_t kBlock = std::size_t{256} << 10;

std::string reason(int error) { return std::generic_category().message(error); }

/// Reads until `count` bytes are there or the file ends; negative errno on failure.
std::ptrdiff_t read_fully(int descriptor, std::byte* to, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t got = ::read(descriptor, to + done, count - done);
    if (got == 0) break;
    if (got > 0) {
      done += static_cast<std::size_t>(got);
    } else if (errno != EINTR) {
      return -errno;
    }
  }
  return static_cast<std::ptrdiff_t>(done);
}

}  // namespace

Result<ByteSource> ByteSource::open(const std::filesystem::path& path) {
  ByteSource source;
  source.file_ = UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!source.file_) return Error{ErrorCode::input_unreadable, path.string() + ": " + reason(errno)};
  struct stat info {};
  if (::fstat(source.file_.get(), &info) != 0)
    return Error{ErrorCode::input_unreadable, path.string() + ": " + reason(errno)};
  if (S_ISDIR(info.st_mode)) return Error{ErrorCode::input_unreadable, path.string() + " is a directory"};
  if (S_ISREG(info.st_mode)) {
    source.unread_ = static_cast<std::uint64_t>(info.st_size);
  } else if (Status read = source.slurp(path); !read) {
    return std::move(read).error();
  }
  return source;
}

Status ByteSource::slurp(const std::filesystem::path& path) {
  std::size_t length = 0;
  for (;;) {
    block_.resize(std::max(2 * length, kBlock));
    const std::ptrdiff_t got = read_fully(file_.get(), block_.data() + length, block_.size() - length);
    if (got < 0) return Error{ErrorCode::input_unreadable, path.string() + ": " + reason(static_cast<int>(-got))};
    length += static_cast<std::size_t>(got);
    if (length < block_.size()) break;
  }
  block_.resize(length);
  cursor_ = block_.data();
  end_ = cursor_ + length;
  return Done{};
}

void ByteSource::refill(std::size_t wanted) {
  if (unread_ == 0) return;
  const auto kept = static_cast<std::size_t>(end_ - cursor_);
  const std::uint64_t room = std::max<std::uint64_t>(wanted, std::min<std::uint64_t>(kBlock, kept + unread_));
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(room, kept + unread_));
  if (size > block_.size()) {
    std::vector<std::byte> larger(size);
    std::copy(cursor_, end_, larger.data());
    block_.swap(larger);
  } else {
    std::memmove(block_.data(), cursor_, kept);
  }
  const std::size_t asked = std::max(size, std::min<std::size_t>(block_.size(), kept + unread_)) - kept;
  const std::ptrdiff_t got = read_fully(file_.get(), block_.data() + kept, asked);
  if (got < 0) failure_ = Error{ErrorCode::input_unreadable, "reading failed: " + reason(static_cast<int>(-got))};
  const std::size_t read = got < 0 ? 0 : static_cast<std::size_t>(got);
  // A file that became shorter while it was read ends here.
  unread_ = read < asked ? 0 : unread_ - read;
  cursor_ = block_.data();
  end_ = cursor_ + kept + read;
}

bool ByteSource::skip(std::uint64_t count) {
  while (count > 0) {
    const std::size_t there = peek(1).size();
    if (there == 0) return false;
    const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(count, there));
    advance(step);
    count -= step;
  }
  return true;
}

}  // namespace surfaced::io
