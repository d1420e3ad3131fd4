// Messages of the Haply Inverse Service: JSON over WebSocket, as documented for version 3.5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/solver/pose.h"

namespace palpa::inverse3 {

/// Size limit of a message; the service sends about 2 kB per device. Larger: a malicious peer costs more memory; smaller: a
/// service with many devices is refused.
inline constexpr std::size_t longest_message_bytes = std::size_t{256} << 10;

/// Key of the force in `set_cursor_force`: documented as `vector` since 3.5, before as `values`.
enum class ForceWord : std::uint8_t { vector, values };

/// State of an Inverse3; a key missing in a message keeps its value. Hand frame.
struct ServiceArm {
  std::optional<Vec3> position_m;        ///< none: not received yet
  std::optional<Vec3> velocity_m_per_s;  ///< none: never sent
  std::optional<Vec3> reported_force_n;  ///< of the motors, in the last message only
  bool is_calibrated = true;             ///< if missing: older services report it otherwise
  bool has_power = true;                 ///< as above
};

/// Handle with buttons.
struct ServiceGrip {
  std::string device_id;
  bool is_wireless = false;
  bool is_connected = true;   ///< if missing: listed grips are connected
  bool is_awake = true;       ///< as above
  std::uint32_t buttons = 0;  ///< 0 if disconnected or asleep
  std::optional<Turn> turn;   ///< orientation, of unit length; none: never sent, or all zero
};

/// State received from a service.
struct ServiceView {
  std::vector<std::string> device_ids;  ///< of all Inverse3, in the service's order
  std::optional<ServiceArm> arm;        ///< the requested arm; none: not listed
  std::vector<ServiceGrip> grips;

  std::uint32_t buttons() const noexcept;            ///< of all grips: no message maps grips to arms
  bool has(const ServiceGrip& grip) const noexcept;  ///< listed and connected
  /// The listed grip of this kind and id; null: none.
  const ServiceGrip* find(const ServiceGrip& grip) const noexcept;
};

/// Applies a message to `view`. False, with `view` unchanged, for anything that is not a message of the service: no JSON, too
/// deep, wrong type, number missing, not finite or out of range.
/// \param device_id  of `arm`; empty: the first Inverse3
bool read_message(std::string_view text, const std::string& device_id, ServiceView& view);

/// True for a valid device id: 1 to 64 letters, digits, '_', '-', '.' and ':'; safe in descriptions and sentences.
bool is_plain(std::string_view text) noexcept;

/// Command to one arm.
/// \param force_n  [N] on the hand, in the hand frame; finite
/// \param profile  plain; empty: only the first message of a connection names the session's profile
std::string force_message(const std::string& device_id, const Vec3& force_n, ForceWord word, const std::string& profile = {});
/// Request for the service's full state.
std::string snapshot_request(const std::string& profile = {});

/// Key of the force for a service, from its answer to GET /version. None: no version in the answer.
std::optional<ForceWord> word_of_version(std::string_view answer);

}  // namespace palpa::inverse3
