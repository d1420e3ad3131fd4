// How a scan was made, as its file says it: a short list of facts, none of them about a person.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpa {

enum class ScanFactKind : std::uint8_t {
  body_part,  ///< "head"
  protocol,   ///< the known words of the protocol's name: "head routine"
  image,      ///< what is shown where that is not the signal itself: "phase map", "ADC map"
  angiogram,  ///< "yes"
  contrast,   ///< "yes": with a contrast agent
  scanner,    ///< maker and model
  kernel,     ///< of the reconstruction
  sequence,   ///< of MR, in words
  slice_thickness_mm,
  tube_voltage_kv,
  tube_current_ma,
  field_strength_t,
  repetition_time_ms,
  echo_time_ms,
  inversion_time_ms,
  flip_angle_deg,
  b_value_s_per_mm2,
  velocity_range_cm_per_s,  ///< fastest velocity that is measured (VENC)
};
inline constexpr std::size_t scan_fact_kinds = 18;

struct ScanFact {
  ScanFactKind kind = ScanFactKind::body_part;
  std::string words;    ///< of kinds that are said in words; else empty
  double number = 0.0;  ///< in the kind's own unit, which its name ends with; finite
  friend bool operator==(const ScanFact&, const ScanFact&) = default;
};

/// The kind's name: "body_part", …
std::string_view name_of(ScanFactKind kind) noexcept;
/// Whether facts of this kind are numbers.
constexpr bool is_number(ScanFactKind kind) noexcept { return kind >= ScanFactKind::slice_thickness_mm; }

}  // namespace palpa
