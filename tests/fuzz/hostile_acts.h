// Acts of a hostile reader, as a campaign writes them to a file.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <ostream>
#include <string>

namespace palpa::fuzz {

struct Act {
  enum Kind : std::uint8_t {
    send,     ///< the bytes as one packet
    receive,  ///< any message
    fill,     ///< the received memory, with the bytes repeated
    shrink,
    close,  ///< its end of the socket
    spin,   ///< endless
    hang,   ///< endless
    crash,
  };
  Kind kind = send;
  std::string bytes{};
};

inline void put_act(std::ostream& out, const Act& act) {
  out.put(static_cast<char>(act.kind));
  out << act.bytes.size() << ' ' << act.bytes;
}

inline std::optional<Act> next_act(std::istream& in) {
  Act act;
  const int kind = in.get();
  std::size_t size = 0;
  if (kind < 0 || !(in >> size)) return std::nullopt;
  in.get();
  act.kind = static_cast<Act::Kind>(kind);
  act.bytes.resize(size);
  in.read(act.bytes.data(), static_cast<std::streamsize>(size));
  return act;
}

}  // namespace palpa::fuzz
