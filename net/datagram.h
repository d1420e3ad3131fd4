// Datagrams beside a WebSocket: what both sides have in common.
#pragma once

#include <openssl/crypto.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "net/stream.h"

namespace palpa::net {

using asio::ip::udp;
using DatagramSocket = asio::basic_datagram_socket<udp, Strand>;

/// Secret of one connection, at the beginning of each of its datagrams, which are not encrypted. Without a message behind it a
/// datagram is a ping; a server answers it by its like.
using DatagramKey = std::array<std::byte, 16>;

/// [bytes] of a datagram of either side.
inline constexpr std::size_t longest_datagram_bytes = sizeof(DatagramKey) + longest_message_bytes;
/// [bytes] of a message that is sent as a datagram; longer ones take the WebSocket. More: networks cut datagrams in pieces, and
/// firewalls drop those; fewer: models wait for TCP.
inline constexpr std::size_t longest_whole_bytes = 1400;

/// Offer of datagrams, by the server over the WebSocket, once: the key, and the UDP port of the server's address.
struct DatagramOffer {
  DatagramKey key{};
  std::uint16_t port = 0;
};

/// As a message of docs/far.md, with a kind that hands and data do not have.
inline constexpr std::size_t offer_bytes = 34;
inline constexpr std::array<std::byte, 16> offer_head{std::byte{1}, {}, std::byte{128}, {}, std::byte{offer_bytes}};

inline std::array<std::byte, offer_bytes> offer_message(const DatagramOffer& offer) noexcept {
  std::array<std::byte, offer_bytes> message{};
  std::ranges::copy(offer_head, message.begin());
  std::ranges::copy(offer.key, message.begin() + offer_head.size());
  message[32] = static_cast<std::byte>(offer.port & 0xff);
  message[33] = static_cast<std::byte>(offer.port >> 8);
  return message;
}
/// None: a message of another kind, or damaged.
inline std::optional<DatagramOffer> offer_of(std::span<const std::byte> message) noexcept {
  if (message.size() != offer_bytes || !std::ranges::equal(message.first(offer_head.size()), offer_head)) return std::nullopt;
  DatagramOffer offer;
  std::ranges::copy(message.subspan(offer_head.size(), offer.key.size()), offer.key.begin());
  offer.port = static_cast<std::uint16_t>(std::to_integer<unsigned>(message[32]) | std::to_integer<unsigned>(message[33]) << 8);
  return offer;
}
/// Any message of a kind of this folder's own, also of a later version.
inline bool is_of_transport(std::span<const std::byte> message) noexcept {
  return message.size() > 2 && std::to_integer<unsigned>(message[2]) >= 128;
}

/// Message of a datagram, empty for a ping; none if it begins with another key, or is too long. Compares in constant time.
inline std::optional<std::span<const std::byte>> message_of(std::span<const std::byte> datagram,
                                                            const DatagramKey& key) noexcept {
  if (datagram.size() < key.size() || datagram.size() > longest_datagram_bytes) return std::nullopt;
  if (::CRYPTO_memcmp(datagram.data(), key.data(), key.size()) != 0) return std::nullopt;
  return datagram.subspan(key.size());
}

/// Sends a datagram without waiting; a full socket loses it. Any thread.
/// \param message  empty: a ping
/// \param to       nullptr: where the socket is connected to
inline void send_datagram(int socket, const DatagramKey& key, std::span<const std::byte> message,
                          const udp::endpoint* to) noexcept {
  iovec parts[] = {{const_cast<std::byte*>(key.data()), key.size()}, {const_cast<std::byte*>(message.data()), message.size()}};
  msghdr datagram{};
  if (to) {
    datagram.msg_name = const_cast<asio::detail::socket_addr_type*>(to->data());
    datagram.msg_namelen = static_cast<socklen_t>(to->size());
  }
  datagram.msg_iov = parts;
  datagram.msg_iovlen = 2;
  [[maybe_unused]] const ssize_t lost_if_negative = ::sendmsg(socket, &datagram, MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace palpa::net
