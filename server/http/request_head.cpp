// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/request_head.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "platform/lists.hpp"
#include "platform/network.hpp"

namespace surfaced::http {
namespace {

constexpr std::size_t kMaxFields = 100;
/// Pairs of a query; no method has as many parameters.
constexpr std::size_t kMaxPairs = 200;
constexpr std::size_t kLongestHost = 255;
constexpr unsigned kLastPort = 65535;

Error refuse(std::string detail) { return {ErrorCode::invalid_request, std::move(detail)}; }

bool is_token(std::string_view text) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || kMarks.find(c) != kMarks.npos;
  });
}

bool is_control(char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F; }

/// Takes one line that ends with CR LF off the text.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find("\r\n");
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == text.npos ? text.size() : end + 2);
  return line;
}

/// Length of the sequence that this byte begins; 0 for none.
std::size_t sequence_length(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

bool names_close(const Headers& headers) {
  for (const auto& [name, value] : headers) {
    if (!same_name(name, "Connection")) continue;
    for (std::string_view list = value; !list.empty();) {
      if (same_name(take_entry(list), "close")) return true;
    }
  }
  return false;
}

/// Takes http://host:port off a target in absolute form (RFC 9112 §3.2.2), and keeps it as the host that is meant.
std::string_view without_authority(std::string_view target, std::string& authority) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!same_name(target.substr(0, scheme.size()), scheme)) continue;
    target.remove_prefix(scheme.size());
    const std::size_t end = std::min(target.find_first_of("/?#"), target.size());
    authority = target.substr(0, end);
    return target.substr(end);
  }
  return target;
}

Status read_request_line(std::string_view line, RequestHead& head, std::string& authority) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == line.npos || first == last) return refuse("the request line is not 'METHOD target HTTP/1.1'");
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!is_token(method) || method.size() > 32) return refuse("the request method is not a word of HTTP");
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return refuse("the version is not HTTP/1.1 or HTTP/1.0");
  std::string_view rest = without_authority(target, authority);
  const bool absolute = rest.size() != target.size();
  if (absolute && !is_host(authority)) return refuse("the request target names no host");
  if (!(absolute || rest.starts_with('/')) ||
      std::ranges::any_of(rest, [](char c) { return is_control(c) || c == ' '; })) {
    return refuse("the request target is neither a path that begins with / nor a URL");
  }
  rest = rest.substr(0, rest.find('#'));
  const std::size_t mark = rest.find('?');
  head.method = method;
  head.path = rest.substr(0, mark);
  if (head.path.empty()) head.path = "/";
  head.query = mark == rest.npos ? std::string_view() : rest.substr(mark + 1);
  head.close = version == "HTTP/1.0";
  return Done{};
}

Status read_fields(std::string_view text, RequestHead& head) {
  for (std::size_t count = 0; !text.starts_with("\r\n"); ++count) {
    if (count == kMaxFields) {
      return Error{ErrorCode::headers_too_large, "more than " + std::to_string(kMaxFields) + " header fields"};
    }
    const std::string_view line = take_line(text);
    const std::size_t colon = line.find(':');
    // A folded line begins with a space, which no name holds.
    if (colon == line.npos || !is_token(line.substr(0, colon))) return refuse("a header line is not 'Name: value'");
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (std::ranges::any_of(value, is_control)) return refuse("a header field holds a control character");
    head.headers.add(std::string(line.substr(0, colon)), std::string(value));
  }
  return Done{};
}

Status read_framing(RequestHead& head) {
  const auto length = head.headers.find("Content-Length");
  const auto encoding = head.headers.find("Transfer-Encoding");
  if (length && encoding) return refuse("Content-Length and Transfer-Encoding exclude each other");
  if (head.headers.count("Content-Length") > 1 || head.headers.count("Transfer-Encoding") > 1) {
    return refuse("Content-Length or Transfer-Encoding is given twice");
  }
  if (length) {
    std::uint64_t bytes = 0;
    const auto [end, failed] = std::from_chars(length->data(), length->data() + length->size(), bytes);
    if (failed != std::errc() || end != length->data() + length->size()) {
      return refuse("Content-Length is no number: " + std::string(length->substr(0, 40)));
    }
    head.framing = LengthBody{bytes};
  } else if (encoding) {
    if (!same_name(*encoding, "chunked")) return refuse("the only Transfer-Encoding taken is chunked");
    head.framing = ChunkedBody{};
  }
  return Done{};
}

}  // namespace

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const auto first = static_cast<unsigned char>(text.front());
    const std::size_t length = sequence_length(first);
    if (length == 0 || length > text.size()) return false;
    for (std::size_t i = 1; i < length; ++i) {
      if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return false;
    }
    const auto second = length > 1 ? static_cast<unsigned char>(text[1]) : 0U;
    if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) ||
        (first == 0xF4 && second > 0x8F)) {
      return false;
    }
    text.remove_prefix(length);
  }
  return true;
}

Result<RequestHead> parse_head(std::string_view text) {
  RequestHead head;
  std::string authority;
  if (Status read = read_request_line(take_line(text), head, authority); !read.ok()) return read.error();
  if (Status read = read_fields(text, head); !read.ok()) return read.error();
  if (head.headers.count("Host") > 1 || (!head.close && head.headers.count("Host") == 0)) {
    return refuse("a request of HTTP/1.1 has one Host header");
  }
  if (const auto host = head.headers.find("Host"); host && !is_host(*host)) {
    return refuse("the Host header is not a host, or a host and a port: " + std::string(host->substr(0, 40)));
  }
  // The host of the target counts, whatever the header says.
  if (!authority.empty()) head.headers.set("Host", std::move(authority));
  if (Status read = read_framing(head); !read.ok()) return read.error();
  head.close |= names_close(head.headers);
  const auto expect = head.headers.find("Expect");
  head.expects_continue = expect && same_name(*expect, "100-continue");
  return head;
}

std::string percent_encode(std::string_view text) {
  constexpr std::string_view kPlain = "-._~";
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || kPlain.find(c) != kPlain.npos) {
      encoded += c;
    } else {
      encoded += '%';
      encoded += kDigits[byte >> 4U];
      encoded += kDigits[byte & 0xFU];
    }
  }
  return encoded;
}

Result<std::string> percent_decode(std::string_view text, bool plus_is_space) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '+' && plus_is_space) c = ' ';
    if (c == '%') {
      unsigned byte = 0;
      const char* const digits = text.data() + i + 1;
      if (text.size() - i < 3 || std::from_chars(digits, digits + 2, byte, 16).ptr != digits + 2) {
        return refuse("the URL has a '%' without two hexadecimal digits after it");
      }
      c = static_cast<char>(byte);
      i += 2;
    }
    if (c == '\0') return refuse("the URL holds a NUL byte");
    decoded += c;
  }
  if (!is_utf8(decoded)) return refuse("the URL holds bytes that are no UTF-8");
  return decoded;
}

bool is_host(std::string_view text) {
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == text.npos || !is_ip_address(text.substr(1, end - 1)) || text.find(':') > end) return false;
    port = text.substr(end + 1);
  } else {
    const std::string_view name = text.substr(0, text.find(':'));
    port = text.substr(name.size());
    const bool clean = std::ranges::all_of(name, [](char c) {
      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '.' ||
             c == '_';
    });
    if (name.empty() || name.size() > kLongestHost || !clean) return false;
  }
  if (port.empty() || port == ":") return true;
  unsigned number = 0;
  const auto [end, failed] = std::from_chars(port.data() + 1, port.data() + port.size(), number);
  return port.front() == ':' && failed == std::errc() && end == port.data() + port.size() && number <= kLastPort;
}

Result<Query> parse_query(std::string_view text) {
  Query query;
  while (!text.empty()) {
    const std::string_view pair = text.substr(0, text.find('&'));
    text.remove_prefix(std::min(text.size(), pair.size() + 1));
    if (pair.empty()) continue;
    if (query.size() == kMaxPairs) return refuse("the query has more than " + std::to_string(kMaxPairs) + " names");
    const std::size_t equals = pair.find('=');
    auto name = percent_decode(pair.substr(0, equals), true);
    if (!name) return name.error();
    auto value = percent_decode(equals == pair.npos ? std::string_view() : pair.substr(equals + 1), true);
    if (!value) return value.error();
    query.emplace_back(std::move(*name), std::move(*value));
  }
  return query;
}

}  // namespace surfaced::http
