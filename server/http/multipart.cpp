// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/multipart.hpp"

#include <algorithm>
#include <optional>

#include "http/message.hpp"
#include "platform/lists.hpp"

namespace surfaced::http {
namespace {

constexpr std::size_t kMaxBoundary = 70;

Error malformed_part(const std::string& what) { return {ErrorCode::invalid_request, "the multipart body " + what}; }

/// The next `; name=value` of a header field; a quoted value may hold anything, with \ before " and \.
struct Parameter {
  std::string name;
  std::string value;
};
std::optional<Parameter> take_parameter(std::string_view& text) {
  text = trimmed(text);
  if (!text.starts_with(';')) return std::nullopt;
  text = trimmed(text.substr(1));
  const std::size_t equals = text.find('=');
  if (equals == text.npos) return std::nullopt;
  Parameter parameter{std::string(trimmed(text.substr(0, equals))), {}};
  text.remove_prefix(equals + 1);
  text = trimmed(text);
  if (!text.starts_with('"')) {
    parameter.value = trimmed(text.substr(0, text.find(';')));
    text.remove_prefix(std::min(text.size(), text.find(';')));
    return parameter;
  }
  std::size_t at = 1;
  for (; at < text.size() && text[at] != '"'; ++at) {
    if (text[at] == '\\' && at + 1 < text.size()) ++at;
    parameter.value += text[at];
  }
  if (at >= text.size()) return std::nullopt;
  text.remove_prefix(at + 1);
  return parameter;
}

Result<Part> part_of(std::string_view disposition) {
  const std::string_view kind = trimmed(disposition.substr(0, disposition.find(';')));
  if (!same_name(kind, "form-data")) return malformed_part("has a part that is no form-data");
  disposition.remove_prefix(std::min(disposition.size(), disposition.find(';')));
  Part part;
  bool named = false;
  while (const auto parameter = take_parameter(disposition)) {
    if (same_name(parameter->name, "name") && !named) {
      part.name = parameter->value;
      named = true;
    } else if (same_name(parameter->name, "filename") || same_name(parameter->name, "filename*")) {
      part.is_file = true;
    }
  }
  if (!named || part.name.empty()) return malformed_part("has a part without a name");
  return part;
}

}  // namespace

Result<std::string> multipart_boundary(std::string_view content_type) {
  content_type.remove_prefix(std::min(content_type.size(), content_type.find(';')));
  while (const auto parameter = take_parameter(content_type)) {
    if (!same_name(parameter->name, "boundary")) continue;
    constexpr std::string_view kSigns = "'()+_,-./:=? ";
    const bool clean = std::ranges::all_of(parameter->value, [&](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             kSigns.find(c) != kSigns.npos;
    });
    if (!clean || parameter->value.empty() || parameter->value.size() > kMaxBoundary) break;
    return parameter->value;
  }
  return Error{ErrorCode::invalid_request,
               "Content-Type multipart/form-data has no boundary of 1 to 70 of the characters that RFC 2046 allows"};
}

MultipartReader::MultipartReader(std::string_view boundary, PartSink sink)
    : delimiter_("\r\n--" + std::string(boundary)), sink_(std::move(sink)) {}

Status MultipartReader::feed(std::span<const std::byte> bytes) {
  if (state_ == State::over) return Done{};
  buffer_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (;;) {
    const auto more = step();
    if (!more) return more.error();
    if (!*more) return Done{};
  }
}

Status MultipartReader::finish() const {
  if (state_ == State::over) return Done{};
  return malformed_part("ends before its last boundary");
}

Result<bool> MultipartReader::step() {
  switch (state_) {
    case State::before:
      return skip_preamble();
    case State::after_boundary:
      return after_boundary();
    case State::head:
      return read_head();
    case State::body:
      return read_body();
    case State::over:
      buffer_.clear();
      return false;
  }
  return false;
}

Result<bool> MultipartReader::skip_preamble() {
  const std::size_t at = buffer_.find(delimiter_);
  if (at == buffer_.npos) {
    if (buffer_.size() > kMaxHead) return malformed_part("does not begin with the boundary that Content-Type gives");
    return false;
  }
  buffer_.erase(0, at + delimiter_.size());
  state_ = State::after_boundary;
  return true;
}

Result<bool> MultipartReader::after_boundary() {
  // Blanks may follow a boundary, before the end of its line or of everything.
  const std::size_t text = buffer_.find_first_not_of(" \t");
  if (text == buffer_.npos || buffer_.size() < text + 2) {
    if (buffer_.size() > kMaxHead) return malformed_part("has a boundary whose line does not end");
    return false;
  }
  const std::string_view next = std::string_view(buffer_).substr(text, 2);
  if (next == "--") {
    state_ = State::over;
    return true;
  }
  if (next != "\r\n") return malformed_part("has a boundary with something behind it");
  if (++parts_ > kMaxParts) return malformed_part("has more than " + std::to_string(kMaxParts) + " parts");
  // The line break stays: it ends the empty head of a part without fields.
  buffer_.erase(0, text);
  state_ = State::head;
  return true;
}

Result<bool> MultipartReader::read_head() {
  const std::size_t end = buffer_.find("\r\n\r\n");
  if (std::min(end, buffer_.size()) > kMaxHead) {
    return malformed_part("has a part whose head has more than " + std::to_string(kMaxHead) + " bytes");
  }
  if (end == buffer_.npos) return false;
  std::string_view head = std::string_view(buffer_).substr(0, end);
  std::optional<std::string> disposition;
  while (!head.empty()) {
    head.remove_prefix(std::min<std::size_t>(head.size(), 2));
    const std::string_view line = head.substr(0, head.find("\r\n"));
    head.remove_prefix(line.size());
    const std::size_t colon = line.find(':');
    if (colon == line.npos) return malformed_part("has a part with a header line without a colon");
    if (same_name(line.substr(0, colon), "Content-Disposition")) disposition = line.substr(colon + 1);
  }
  if (!disposition) return malformed_part("has a part without Content-Disposition");
  const auto part = part_of(*disposition);
  if (!part) return part.error();
  buffer_.erase(0, end + 4);
  if (Status begun = sink_.begin(*part); !begun.ok()) return begun.error();
  state_ = State::body;
  return true;
}

Result<bool> MultipartReader::read_body() {
  const std::size_t at = buffer_.find(delimiter_);
  // The end of the buffer may be the beginning of a boundary.
  const std::size_t safe = at != buffer_.npos ? at : buffer_.size() - std::min(buffer_.size(), delimiter_.size() - 1);
  if (safe > 0) {
    if (Status taken = sink_.data(std::as_bytes(std::span(buffer_).first(safe))); !taken.ok()) return taken.error();
    buffer_.erase(0, safe);
  }
  if (at == buffer_.npos) return false;
  buffer_.erase(0, delimiter_.size());
  if (Status ended = sink_.end(); !ended.ok()) return ended.error();
  state_ = State::after_boundary;
  return true;
}

}  // namespace surfaced::http
