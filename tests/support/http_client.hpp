// SPDX-License-Identifier: GPL-3.0-or-later
// A client that can be as rude as a test needs: bytes out, bytes in.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace surfaced::testing {

struct Answer {
  /// 0 if the server closed without an answer.
  int status = 0;
  /// Names in lower case.
  std::map<std::string, std::string> headers;
  std::string body;
};

/// One connection to 127.0.0.1.
class RawConnection {
 public:
  explicit RawConnection(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    // Who is not read from for this long is as good as cut off.
    const timeval patience{60, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      ::close(fd_);
      throw std::runtime_error("cannot connect to port " + std::to_string(port));
    }
  }
  virtual ~RawConnection() { ::close(fd_); }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  /// False once the server does not take any more.
  virtual bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (count <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }

  /// Says that nothing more will come.
  void end() const { ::shutdown(fd_, SHUT_WR); }

  /// The next answer.
  /// @param head_only  for HEAD
  Answer read_answer(bool head_only = false, std::chrono::milliseconds patience = std::chrono::seconds(60)) {
    Answer answer;
    std::size_t end = 0;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (!more(patience)) return answer;
    }
    parse_head(buffer_.substr(0, end + 2), answer);
    buffer_.erase(0, end + 4);
    if (answer.status == 100) return read_answer(head_only, patience);
    const auto length = answer.headers.find("content-length");
    const std::size_t size = head_only || length == answer.headers.end() ? 0 : std::stoul(length->second);
    while (buffer_.size() < size) {
      if (!more(patience)) break;
    }
    answer.body = buffer_.substr(0, size);
    buffer_.erase(0, answer.body.size());
    return answer;
  }

  /// True if something of an answer is there within this time.
  bool hears_within(std::chrono::milliseconds patience) { return !buffer_.empty() || arrives_within(patience); }

  /// True if the server closes the connection, within this time after its last byte.
  bool closes(std::chrono::milliseconds patience = std::chrono::seconds(60)) {
    while (more(patience)) {
    }
    return closed_;
  }

 protected:
  int descriptor() const { return fd_; }

  /// True if something can be received within this time.
  virtual bool arrives_within(std::chrono::milliseconds patience) {
    pollfd descriptor{fd_, POLLIN, 0};
    return ::poll(&descriptor, 1, static_cast<int>(patience.count())) > 0;
  }
  virtual ssize_t receive(char* bytes, std::size_t size) { return ::recv(fd_, bytes, size, 0); }

 private:
  bool more(std::chrono::milliseconds patience) {
    if (!arrives_within(patience)) return false;
    std::array<char, 65536> bytes{};
    const ssize_t count = receive(bytes.data(), bytes.size());
    closed_ = count <= 0;
    if (count > 0) buffer_.append(bytes.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

  static void parse_head(const std::string& head, Answer& answer) {
    answer.status = std::stoi(head.substr(9, 3));
    for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
      const std::size_t end = head.find("\r\n", at);
      const std::size_t colon = head.find(':', at);
      std::string name = head.substr(at, colon - at);
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
      answer.headers[name] = head.substr(colon + 2, end - colon - 2);
      at = end + 2;
    }
  }

  int fd_;
  std::string buffer_;
  bool closed_ = false;
};

using Fields = std::vector<std::pair<std::string, std::string>>;

/// One request on a connection of its own.
inline Answer call(std::uint16_t port, const std::string& method, const std::string& target, std::string_view body = {},
                   const Fields& fields = {}) {
  RawConnection connection(port);
  std::string head = method + " " + target + " HTTP/1.1\r\nHost: test\r\nConnection: close\r\n";
  for (const auto& [name, value] : fields) head.append(name).append(": ").append(value).append("\r\n");
  if (method == "POST" || method == "PUT") head += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  connection.send(head + "\r\n");
  connection.send(body);
  return connection.read_answer(method == "HEAD");
}

}  // namespace surfaced::testing
