// The network's shared object, loaded at the first use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "net/net.h"

namespace palpa::app {

/// Throws LoadError in a build without it, or if loading fails.
const Net& net();

struct NetPlace {
  std::string host;
  std::uint16_t port = 0;
};
/// Parsed `HOST:PORT` or `[::1]:PORT`. Throws LoadError.
NetPlace net_place(const std::string& text);
/// Whether a host is this machine by its name: "localhost", "127.0.0.1", "::1".
bool is_loopback(const std::string& host);
/// Whether a message may be lost, come twice, or after newer ones: probes and models. All others need a reliable connection.
bool may_be_lost(std::span<const std::byte> message) noexcept;

}  // namespace palpa::app
