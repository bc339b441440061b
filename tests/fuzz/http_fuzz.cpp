// SPDX-License-Identifier: GPL-3.0-or-later
// The way of a request's bytes to a handler: head, path, query, Range, chunks. Whatever is accepted must keep to what
// request_head.hpp and chunk_guard.hpp promise.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "http/chunk_guard.hpp"
#include "http/conditional.hpp"
#include "http/request_head.hpp"

namespace {

using namespace surfaced;

void require(bool holds) {
  if (!holds) std::abort();
}

bool plain(std::string_view text) {
  for (const char c : text) {
    if (c == '\r' || c == '\n' || c == '\0') return false;
  }
  return true;
}

void fuzz_head(std::string_view text) {
  const auto head = http::parse_head(text);
  if (!head) return;
  require(!head->method.empty() && plain(head->method) && plain(head->path) && plain(head->query));
  std::size_t fields = 0;
  for (const auto& [name, value] : head->headers) {
    require(!name.empty() && plain(name) && plain(value));
    ++fields;
  }
  require(fields <= 100);
  require(head->headers.count("Content-Length") == 0 || head->headers.count("Transfer-Encoding") == 0);
  if (const auto path = http::percent_decode(head->path, false)) require(path->find('\0') == path->npos);
  if (const auto query = http::parse_query(head->query)) {
    for (const auto& [name, value] : *query) require(value.find('\0') == value.npos);
  }
  const auto range = http::requested_range(head->headers, "\"tag\"", 1000);
  if (range && range->has_value()) {
    require((*range)->length > 0 && (*range)->offset < 1000 && (*range)->offset + (*range)->length <= 1000);
  }
}

/// However the bytes are cut, the guard says the same.
void fuzz_chunks(std::string_view bytes, std::size_t cut) {
  http::ChunkGuard whole;
  http::ChunkGuard parts;
  const bool accepted = whole.accept(bytes);
  const bool first = parts.accept(bytes.substr(0, cut));
  const bool second = first && parts.accept(bytes.substr(cut));
  require(accepted == second);
  if (accepted) require(whole.complete() == parts.complete());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz_head(text);
  if (size > 0) fuzz_chunks(text.substr(1), data[0] % size);
  return 0;
}
