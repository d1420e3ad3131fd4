#include "palpa/data/volume.h"

namespace palpa {

std::string_view name_of(ScanFactKind kind) noexcept {
  static constexpr std::string_view names[scan_fact_kinds] = {"body_part",
                                                              "protocol",
                                                              "image",
                                                              "angiogram",
                                                              "contrast",
                                                              "scanner",
                                                              "kernel",
                                                              "sequence",
                                                              "slice_thickness_mm",
                                                              "tube_voltage_kv",
                                                              "tube_current_ma",
                                                              "field_strength_t",
                                                              "repetition_time_ms",
                                                              "echo_time_ms",
                                                              "inversion_time_ms",
                                                              "flip_angle_deg",
                                                              "b_value_s_per_mm2",
                                                              "velocity_range_cm_per_s"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace palpa
