// SPDX-License-Identifier: GPL-3.0-or-later
#include "platform/network.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "platform/lists.hpp"

namespace surfaced {
namespace {

constexpr AddressBytes kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
constexpr std::size_t kMappedBytes = 12;
constexpr unsigned kMappedBits = 96;
constexpr std::size_t kGroupBytes = 8;
constexpr std::uint8_t kLoopback4 = 127;

bool is_mapped(const AddressBytes& address) {
  return std::equal(kMapped.begin(), kMapped.begin() + kMappedBytes, address.begin());
}

std::string text_of(const AddressBytes& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool four = is_mapped(address);
  const char* const written =
      ::inet_ntop(four ? AF_INET : AF_INET6, address.data() + (four ? kMappedBytes : 0), text.data(), text.size());
  return written == nullptr ? std::string() : std::string(written);
}

}  // namespace

std::optional<AddressBytes> address_in(std::string_view text) {
  if (text.size() >= INET6_ADDRSTRLEN || text.find('\0') != text.npos) return std::nullopt;
  const std::string whole(text);
  AddressBytes bytes = kMapped;
  if (::inet_pton(AF_INET, whole.c_str(), bytes.data() + kMappedBytes) == 1) return bytes;
  if (::inet_pton(AF_INET6, whole.c_str(), bytes.data()) == 1) return bytes;
  return std::nullopt;
}

bool is_ip_address(std::string_view text) { return address_in(text).has_value(); }

bool is_loopback(std::string_view host) {
  if (host == "localhost") return true;
  const auto address = address_in(host);
  if (!address) return false;
  if (is_mapped(*address)) return (*address)[kMappedBytes] == kLoopback4;
  return std::all_of(address->begin(), address->end() - 1, [](std::uint8_t byte) { return byte == 0; }) &&
         address->back() == 1;
}

std::string client_group(std::string_view client) {
  auto address = address_in(client);
  if (!address) return std::string(client);
  if (is_mapped(*address) || is_loopback(client)) return text_of(*address);
  std::fill(address->begin() + kGroupBytes, address->end(), std::uint8_t{0});
  return text_of(*address) + "/64";
}

std::optional<Network> Network::parse(std::string_view text) {
  const std::string_view before = text.substr(0, text.find('/'));
  const auto address = address_in(before);
  if (!address) return std::nullopt;
  Network network;
  network.address_ = *address;
  if (before.size() == text.size()) return network;
  const std::string_view digits = text.substr(before.size() + 1);
  const unsigned offset = before.find(':') == before.npos ? kMappedBits : 0;
  unsigned bits = 0;
  const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), bits);
  if (failed != std::errc() || end != digits.data() + digits.size() || bits > network.bits_ - offset) {
    return std::nullopt;
  }
  network.bits_ = bits + offset;
  return network;
}

Result<std::vector<Network>> networks_in(std::string_view list) {
  std::vector<Network> networks;
  while (!list.empty()) {
    const std::string_view entry = take_entry(list);
    if (entry.empty()) continue;
    const auto network = Network::parse(entry);
    if (!network) {
      return Error{ErrorCode::invalid_usage, "'" + std::string(entry) +
                                                 "'; allowed are addresses (192.0.2.1) and networks (10.0.0.0/8, "
                                                 "2001:db8::/32)"};
    }
    networks.push_back(*network);
  }
  return networks;
}

bool Network::holds(const AddressBytes& address) const {
  constexpr unsigned kByte = 8;
  const std::size_t whole = bits_ / kByte;
  if (!std::equal(address_.begin(), address_.begin() + static_cast<std::ptrdiff_t>(whole), address.begin())) {
    return false;
  }
  const unsigned rest = bits_ % kByte;
  if (rest == 0) return true;
  const unsigned differing = static_cast<unsigned>(address_.at(whole)) ^ static_cast<unsigned>(address.at(whole));
  return differing >> (kByte - rest) == 0;
}

}  // namespace surfaced
