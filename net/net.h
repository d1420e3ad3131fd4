// Interface of the shared object palpa-net.so to the program: binary messages over WebSocket, plain or over TLS,
// and datagrams beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace palpa {

/// Where a server listens.
struct NetServerOptions {
  std::string address = "127.0.0.1";       ///< of this machine: digits, or a name
  std::uint16_t port = 4711;               ///< 0: any that is free
  std::filesystem::path certificate, key;  ///< PEM; empty: no TLS
  bool datagrams = false;                  ///< offer them for what may be lost, unencrypted, at the same port of UDP
};

/// One admitted connection. Each function is called by one thread at a time, not always by the same.
class NetUser {
 public:
  virtual ~NetUser() = default;  ///< the connection has ended
  /// Takes a binary message of any content. Returns why the connection has to end; empty: it goes on. Exceptions end it, too.
  virtual std::string take(std::span<const std::byte> message) = 0;
  /// Writes the next message. Called when the one before has gone to the system: after each message taken, and 60 times a
  /// second. Returns its length [bytes]; 0: none now.
  /// \param to  8192 bytes
  virtual std::size_t give(std::span<std::byte> to) = 0;
  /// Whether a message, to be given or taken, may go by a datagram: be lost, come twice, or after newer ones.
  virtual bool may_be_lost(std::span<const std::byte>) const noexcept { return false; }
  /// Its messages that may be lost go by datagrams from now on, or no longer.
  virtual void set_by_datagrams(bool) {}
  /// Whether its messages are text; they never go by datagrams.
  virtual bool gives_text() const noexcept { return false; }
};

/// Admission to a server. Any thread, several at a time.
class NetService {
 public:
  virtual ~NetService() = default;
  /// Admits a connection by its first message, of any content. Throws LoadError with the reason against it.
  virtual std::unique_ptr<NetUser> admit(std::span<const std::byte> first_message) = 0;
  /// Reports a connection that was refused or ended for a reason, in one line without its end.
  virtual void report(const std::string& line) = 0;
};

/// Listens from construction to destruction, which ends all connections.
class NetServer {
 public:
  virtual ~NetServer() = default;
  virtual std::uint16_t port() const noexcept = 0;
};

/// Where a client connects to.
struct NetClientOptions {
  std::string host;
  std::uint16_t port = 4711;
  bool has_tls = false;             ///< the certificate must be for `host`
  std::filesystem::path authority;  ///< PEM: that signed it; empty: one known to the system
  /// Whether a message, to be sent or received, may go by a datagram: be lost, come twice, or after newer ones. It does where
  /// the server offers datagrams and the network carries them. nullptr: none may.
  bool (*may_be_lost)(std::span<const std::byte> message) noexcept = nullptr;
};

/// Connection to a server, opened again after each loss until destruction. A thread of its own has the socket; messages pass by
/// two rings. Messages of earlier connections are never received.
class NetClient {
 public:
  virtual ~NetClient() = default;

  // One thread, that of a tick: neither allocate, lock nor block.

  /// Number [1] of the open connection, from 1; 0: closed. Atomic; any thread.
  virtual std::uint32_t connection() const noexcept = 0;
  /// Sends on that connection. False: no room now, since the socket is full; nothing is sent.
  virtual bool send(std::uint32_t connection, std::span<const std::byte> message) noexcept = 0;
  /// Next binary message of that connection; empty: none. Valid until the next call.
  virtual std::span<const std::byte> receive(std::uint32_t connection) noexcept = 0;

  // Any thread.

  struct Problem {
    std::string words;      ///< why there is no connection; empty: none is known
    bool is_final = false;  ///< the server refused: no further attempt
  };
  virtual Problem problem() const = 0;
  /// [bytes] of messages sent and received so far.
  virtual std::uint64_t sent_bytes() const noexcept = 0;
  virtual std::uint64_t received_bytes() const noexcept = 0;
  /// Datagrams are in use: one came within the last second.
  virtual bool is_by_datagrams() const noexcept = 0;
  /// [1] of messages by datagrams so far.
  virtual std::uint64_t sent_datagrams() const noexcept = 0;
  virtual std::uint64_t received_datagrams() const noexcept = 0;
};

/// Exported as `palpa_net`, a constant of C linkage. Both functions throw LoadError.
struct Net {
  const char* palpa_version;  ///< `palpa::version`: on a mismatch no other member is read
  /// \param service  must outlive the server
  std::unique_ptr<NetServer> (*serve)(const NetServerOptions& options, NetService& service);
  std::unique_ptr<NetClient> (*connect)(const NetClientOptions& options);
};

}  // namespace palpa
