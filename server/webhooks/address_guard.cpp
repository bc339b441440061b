// SPDX-License-Identifier: GPL-3.0-or-later
#include "webhooks/address_guard.hpp"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "observability/log.hpp"

namespace surfaced {
namespace {

struct Block4 {
  std::uint32_t network;
  int bits;
};

constexpr std::uint32_t ip4(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return a << 24U | b << 16U | c << 8U | d;
}

// The special-purpose addresses of IANA (RFC 6890 and its updates).
constexpr auto kNotPublic = std::to_array<Block4>({
    {ip4(0, 0, 0, 0), 8},
    {ip4(10, 0, 0, 0), 8},
    {ip4(100, 64, 0, 0), 10},
    {ip4(127, 0, 0, 0), 8},
    {ip4(169, 254, 0, 0), 16},
    {ip4(172, 16, 0, 0), 12},
    {ip4(192, 0, 0, 0), 24},
    {ip4(192, 0, 2, 0), 24},
    {ip4(192, 88, 99, 0), 24},
    {ip4(192, 168, 0, 0), 16},
    {ip4(198, 18, 0, 0), 15},
    {ip4(198, 51, 100, 0), 24},
    {ip4(203, 0, 113, 0), 24},
    {ip4(224, 0, 0, 0), 4},
    {ip4(240, 0, 0, 0), 4},
});

bool is_public(std::uint32_t address) {
  return std::ranges::none_of(kNotPublic, [&](const Block4& block) {
    return (address ^ block.network) >> static_cast<unsigned>(32 - block.bits) == 0;
  });
}

bool is_public(const std::array<std::uint8_t, 16>& address) {
  // Only 2000::/3 is given out; inside it are documentation and what carries an IPv4 address.
  if ((address[0] & 0xE0U) != 0x20U) return false;
  const auto begins = [&](std::initializer_list<int> bytes) {
    return std::equal(bytes.begin(), bytes.end(), address.begin(), [](int a, std::uint8_t b) { return a == b; });
  };
  const bool teredo_and_the_like = begins({0x20, 0x01}) && (address[2] & 0xFEU) == 0;
  return !teredo_and_the_like && !begins({0x20, 0x01, 0x0d, 0xb8}) && !begins({0x20, 0x02}) && !begins({0x3f, 0xff});
}

Error refuse(const std::string& what) { return {ErrorCode::invalid_parameter, "webhook: " + what}; }

struct FreeUrl {
  void operator()(CURLU* url) const { ::curl_url_cleanup(url); }
};

std::string part_of(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  if (::curl_url_get(url, part, &text, CURLU_DEFAULT_PORT) != CURLUE_OK || text == nullptr) return {};
  std::string copy(text);
  ::curl_free(text);
  return copy;
}

std::vector<std::string> addresses_of(const std::string& host, const std::string& port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  std::vector<std::string> addresses;
  if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return addresses;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    std::array<char, NI_MAXHOST> text{};
    if (::getnameinfo(each->ai_addr, each->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0) {
      addresses.emplace_back(text.data());
    }
  }
  return addresses;
}

}  // namespace

bool is_public_address(std::string_view address) {
  const std::string text(address);
  in_addr four{};
  if (::inet_pton(AF_INET, text.c_str(), &four) == 1) return is_public(ntohl(four.s_addr));
  in6_addr six{};
  if (::inet_pton(AF_INET6, text.c_str(), &six) != 1) return false;
  std::array<std::uint8_t, 16> bytes{};
  std::memcpy(bytes.data(), &six, bytes.size());
  return is_public(bytes);
}

Result<WebhookTarget> resolve_target(const std::string& url, bool private_too) {
  const std::unique_ptr<CURLU, FreeUrl> parsed(::curl_url());
  if (!parsed || ::curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK) {
    return refuse("the URL cannot be understood");
  }
  if (part_of(parsed.get(), CURLUPART_SCHEME) != "https") return refuse("the URL is not https");
  if (!part_of(parsed.get(), CURLUPART_USER).empty()) return refuse("the URL holds a user");
  WebhookTarget target{part_of(parsed.get(), CURLUPART_HOST), part_of(parsed.get(), CURLUPART_PORT), ""};
  std::string name = target.host;
  if (name.starts_with('[') && name.ends_with(']')) name = name.substr(1, name.size() - 2);
  const auto addresses = addresses_of(name, target.port);
  // In the same words for a name that is not known and for one of this network: whoever asks is not to learn which
  // names there are, nor what they resolve to.
  const bool reachable = private_too || std::ranges::all_of(addresses, is_public_address);
  if (addresses.empty() || !reachable) {
    log(LogLevel::info, "a webhook's host has no public address",
        {{"host", target.host}, {"address", addresses.empty() ? "" : addresses.front()}});
    return refuse("the host " + target.host + " has no address, or one that is not public");
  }
  target.address = addresses.front();
  return target;
}

}  // namespace surfaced
