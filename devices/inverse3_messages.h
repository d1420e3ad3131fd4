// What is said between a client and the Haply Inverse Service: JSON texts over a WebSocket, as the service's pages of version
// 3.5 describe them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::inverse3 {

/// The longest message that is taken. One of the service has some two kilobytes for each device. Larger: another side that
/// means harm costs more memory; smaller: a service with many devices is refused.
inline constexpr std::size_t longest_message_bytes = std::size_t{256} << 10;

/// What a force is called in `set_cursor_force`: since 3.5 the service's pages say `vector`, before that `values`.
enum class ForceWord : std::uint8_t { vector, values };

/// An Inverse3 as the service last told of it: what a message leaves out stays. In the hand frame.
struct Arm {
  std::optional<Vec3> position_m;        ///< none: it has not been told yet
  std::optional<Vec3> velocity_m_per_s;  ///< none: it is never told
  std::optional<Vec3> reported_force_n;  ///< that the motors make, of this message alone
  bool is_calibrated = true;             ///< where nothing is told of it: older services say it by other means
  bool has_power = true;                 ///< likewise
};

/// A handle with buttons.
struct Grip {
  std::string device_id;
  bool is_wireless = false;
  bool is_connected = true;   ///< true where the message lacks it: the grip is in the service's list
  bool is_awake = true;       ///< likewise
  std::uint32_t buttons = 0;  ///< none where it is not connected, or asleep
};

/// All that is kept of what a service told.
struct View {
  std::vector<std::string> device_ids;  ///< of all Inverse3, in the service's order
  std::optional<Arm> arm;               ///< the one that was asked for; none: it is not in the service's list
  std::vector<Grip> grips;

  std::uint32_t buttons() const noexcept;     ///< of all grips: none of them says which arm it is on
  bool has(const Grip& grip) const noexcept;  ///< whether it is in the list and connected
};

/// Reads a message over what was known before. False, with `view` as it was: it is not what the service sends. Nothing is
/// taken from such a message: no JSON, too deep, a wrong type, a number missing, not finite or of no possible size.
/// \param device_id  the Inverse3 that `arm` is of; empty: the first one
bool read_message(std::string_view text, const std::string& device_id, View& view);

/// Whether a text can be a device's id: 1 to 64 letters, digits, '_', '-', '.' and ':'. So it can stand in a description and
/// in a sentence.
bool is_plain(std::string_view text) noexcept;

/// A command to one arm.
/// \param force_n  [N] on the hand, in the hand frame; finite
/// \param profile  plain; empty: only the first message of a connection names the session's profile
std::string force_message(const std::string& device_id, const Vec3& force_n, ForceWord word, const std::string& profile = {});
/// Asks for all that the service knows.
std::string snapshot_request(const std::string& profile = {});

/// The word that a service of this version knows, from what it answers to GET /version. None: the answer says no version.
std::optional<ForceWord> word_of_version(std::string_view answer);

}  // namespace palpa::inverse3
