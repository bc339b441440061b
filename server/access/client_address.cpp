// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/client_address.hpp"

#include <algorithm>

#include "platform/lists.hpp"

namespace surfaced {
namespace {

/// Takes the last entry off a list that commas separate.
std::string_view take_last(std::string_view& list) {
  const std::size_t comma = list.rfind(',');
  const std::string_view last = comma == list.npos ? list : list.substr(comma + 1);
  list = comma == list.npos ? std::string_view() : list.substr(0, comma);
  return trimmed(last);
}

/// 192.0.2.1:4711 and [2001:db8::1]:4711 without brackets and port.
std::string_view without_port(std::string_view entry) {
  if (entry.starts_with('[')) return entry.substr(1, std::min(entry.find(']'), entry.size()) - 1);
  const std::size_t colon = entry.find(':');
  return colon != entry.npos && entry.find(':', colon + 1) == entry.npos ? entry.substr(0, colon) : entry;
}

}  // namespace

std::string client_address(const std::string& connection, const http::Headers& headers,
                           const std::vector<Network>& trusted) {
  const auto is_trusted = [&](std::string_view text) {
    const auto address = address_in(text);
    return address && std::ranges::any_of(trusted, [&](const Network& each) { return each.holds(*address); });
  };
  if (!is_trusted(connection)) return connection;
  std::vector<std::string_view> lines;
  for (const auto& [name, value] : headers) {
    if (http::same_name(name, "X-Forwarded-For")) lines.emplace_back(value);
  }
  // Nobody who comes by way of another machine is on this one, whatever the header says.
  const auto believed = [](std::string client) { return is_loopback(client) ? std::string("unknown") : client; };
  std::string client;
  for (; !lines.empty(); lines.pop_back()) {
    std::string_view& line = lines.back();
    while (!line.empty()) {
      const std::string_view entry = take_last(line);
      // An empty entry of a list says nothing (RFC 9110 §5.6.1).
      if (entry.empty()) continue;
      client = without_port(entry);
      if (!is_ip_address(client)) return "unknown";
      if (!is_trusted(client)) return believed(client);
    }
  }
  return client.empty() ? connection : believed(client);
}

}  // namespace surfaced
