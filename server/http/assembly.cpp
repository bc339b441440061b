// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/assembly.hpp"

#include <algorithm>
#include <cstring>
#include <memory>

#include "platform/base64.hpp"

namespace surfaced::http {
namespace {

/// Of the source, encoded at a time; whole groups of three.
constexpr std::size_t kPiece = std::size_t{48} << 10;

/// Fills the bytes from the body's offset on, or says why it cannot.
Status fill(const BodyStream& body, std::uint64_t offset, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const auto count = body.read(offset, bytes);
    if (!count) return count.error();
    if (*count == 0) return Error{ErrorCode::internal_error, "a file has become shorter while it was sent"};
    offset += *count;
    bytes = bytes.subspan(*count);
  }
  return Done{};
}

}  // namespace

BodyStream body_of_static(std::string_view bytes) {
  return {bytes.size(), [bytes](std::uint64_t offset, std::span<std::byte> buffer) {
            const std::size_t count = std::min<std::uint64_t>(buffer.size(), bytes.size() - offset);
            std::memcpy(buffer.data(), bytes.data() + offset, count);
            return Result<std::size_t>(count);
          }};
}

BodyStream body_of(std::string text) {
  const auto shared = std::make_shared<const std::string>(std::move(text));
  return {shared->size(), [shared](std::uint64_t offset, std::span<std::byte> buffer) {
            const std::size_t count = std::min<std::uint64_t>(buffer.size(), shared->size() - offset);
            std::memcpy(buffer.data(), shared->data() + offset, count);
            return Result<std::size_t>(count);
          }};
}

BodyStream base64_of(BodyStream body) {
  const std::uint64_t length = (body.length + 2) / 3 * 4;
  return {length, [body = std::move(body), length](std::uint64_t offset, std::span<std::byte> buffer) {
            // The groups of four that the buffer begins and ends in.
            const std::uint64_t first = offset / 4;
            const std::size_t skipped = offset % 4;
            const std::uint64_t left = body.length - first * 3;
            const auto wanted = std::min<std::uint64_t>(left, (buffer.size() + skipped + 3) / 4 * 3);
            std::string source(std::min<std::uint64_t>(wanted, kPiece), '\0');
            if (Status read = fill(body, first * 3, std::as_writable_bytes(std::span(source))); !read.ok())
              return Result<std::size_t>(read.error());
            const std::string text = base64_encode(source);
            const std::size_t count = std::min<std::uint64_t>({buffer.size(), text.size() - skipped, length - offset});
            std::memcpy(buffer.data(), text.data() + skipped, count);
            return Result<std::size_t>(count);
          }};
}

BodyStream concatenated(std::vector<BodyStream> parts) {
  std::uint64_t length = 0;
  for (const BodyStream& part : parts) length += part.length;
  const auto shared = std::make_shared<const std::vector<BodyStream>>(std::move(parts));
  return {length, [shared](std::uint64_t offset, std::span<std::byte> buffer) {
            for (const BodyStream& part : *shared) {
              if (offset < part.length) {
                const auto most = std::min<std::uint64_t>(buffer.size(), part.length - offset);
                return part.read(offset, buffer.first(most));
              }
              offset -= part.length;
            }
            return Result<std::size_t>(std::size_t{0});
          }};
}

}  // namespace surfaced::http
