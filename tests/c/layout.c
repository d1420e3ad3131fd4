/* Prints the layout of every struct of palpa/c.h, for comparison with abi.txt; fails where a struct has a gap. */
#include <palpa/c.h>
#include <stdio.h>

static int gaps = 0;
static size_t end = 0;

static void field(const char* name, size_t offset, size_t size) {
  printf("  %s %lu %lu\n", name, (unsigned long)offset, (unsigned long)size);
  gaps += offset != end;
  end = offset + size;
}

static void begin(const char* name, size_t size) {
  printf("%s %lu\n", name, (unsigned long)size);
  end = 0;
}

#define BEGIN(type) begin(#type, sizeof(type))
#define FIELD(type, name) field(#name, offsetof(type, name), sizeof(((type*)0)->name))
#define END(type) gaps += end != sizeof(type)

int main(void) {
  printf("abi %lu\n", (unsigned long)PALPA_ABI);
  BEGIN(palpa_grid);
  FIELD(palpa_grid, size);
  FIELD(palpa_grid, type);
  FIELD(palpa_grid, components);
  FIELD(palpa_grid, medical_frame);
  FIELD(palpa_grid, dims);
  FIELD(palpa_grid, origin_m);
  FIELD(palpa_grid, axes_m);
  FIELD(palpa_grid, voxels);
  FIELD(palpa_grid, bytes);
  FIELD(palpa_grid, slope);
  FIELD(palpa_grid, intercept);
  END(palpa_grid);
  BEGIN(palpa_probe);
  FIELD(palpa_probe, size);
  FIELD(palpa_probe, buttons);
  FIELD(palpa_probe, valid);
  FIELD(palpa_probe, has_velocity);
  FIELD(palpa_probe, position_m);
  FIELD(palpa_probe, velocity_m_per_s);
  FIELD(palpa_probe, turn);
  END(palpa_probe);
  BEGIN(palpa_tick);
  FIELD(palpa_tick, size);
  FIELD(palpa_tick, status);
  FIELD(palpa_tick, force_n);
  FIELD(palpa_tick, proxy_m);
  FIELD(palpa_tick, proxy_velocity_m_per_s);
  FIELD(palpa_tick, probe_m);
  FIELD(palpa_tick, probe_velocity_m_per_s);
  FIELD(palpa_tick, probe_step_m);
  FIELD(palpa_tick, error_bound_m);
  FIELD(palpa_tick, given_back_n);
  FIELD(palpa_tick, unborne_n);
  FIELD(palpa_tick, felt_octave);
  FIELD(palpa_tick, probe_valid);
  FIELD(palpa_tick, forced_octave);
  FIELD(palpa_tick, sub_steps);
  FIELD(palpa_tick, iterations);
  FIELD(palpa_tick, dropped);
  FIELD(palpa_tick, work);
  FIELD(palpa_tick, stored_j);
  FIELD(palpa_tick, elastic_j);
  FIELD(palpa_tick, dissipated_j);
  FIELD(palpa_tick, injected_j);
  FIELD(palpa_tick, path_and_release_j);
  FIELD(palpa_tick, damper_j);
  FIELD(palpa_tick, data_motion_j);
  FIELD(palpa_tick, released_j);
  FIELD(palpa_tick, sampling_j);
  FIELD(palpa_tick, sampling_bound_j);
  FIELD(palpa_tick, torque_nm);
  FIELD(palpa_tick, probe_turn);
  FIELD(palpa_tick, proxy_turn);
  FIELD(palpa_tick, probe_turn_step_rad);
  END(palpa_tick);
  BEGIN(palpa_event);
  FIELD(palpa_event, size);
  FIELD(palpa_event, kind);
  FIELD(palpa_event, mode);
  FIELD(palpa_event, unused);
  FIELD(palpa_event, value);
  FIELD(palpa_event, depth_m);
  FIELD(palpa_event, text);
  END(palpa_event);
  BEGIN(palpa_limits);
  FIELD(palpa_limits, size);
  FIELD(palpa_limits, has_motors);
  FIELD(palpa_limits, dead_man_buttons);
  FIELD(palpa_limits, unused);
  FIELD(palpa_limits, max_force_n);
  FIELD(palpa_limits, max_stiffness_n_per_m);
  FIELD(palpa_limits, max_damping_ns_per_m);
  FIELD(palpa_limits, continuous_force_n);
  FIELD(palpa_limits, encoder_step_m);
  FIELD(palpa_limits, damping_ns_per_m);
  FIELD(palpa_limits, token);
  END(palpa_limits);
  BEGIN(palpa_command);
  FIELD(palpa_command, size);
  FIELD(palpa_command, guard);
  FIELD(palpa_command, cause);
  FIELD(palpa_command, link);
  FIELD(palpa_command, brakes);
  FIELD(palpa_command, beyond);
  FIELD(palpa_command, force_n);
  FIELD(palpa_command, coupling_n);
  FIELD(palpa_command, proxy_m);
  FIELD(palpa_command, model_age_s);
  FIELD(palpa_command, round_trip_s);
  END(palpa_command);
  BEGIN(palpa_inverse3_options);
  FIELD(palpa_inverse3_options, size);
  FIELD(palpa_inverse3_options, force_key);
  FIELD(palpa_inverse3_options, version);
  FIELD(palpa_inverse3_options, device_id);
  FIELD(palpa_inverse3_options, grip_id);
  FIELD(palpa_inverse3_options, profile);
  END(palpa_inverse3_options);
  BEGIN(palpa_file_field);
  FIELD(palpa_file_field, name);
  FIELD(palpa_file_field, unit);
  FIELD(palpa_file_field, grid);
  END(palpa_file_field);
  BEGIN(palpa_file_source);
  FIELD(palpa_file_source, name);
  FIELD(palpa_file_source, sha256);
  FIELD(palpa_file_source, bytes);
  END(palpa_file_source);
  BEGIN(palpa_file);
  FIELD(palpa_file, size);
  FIELD(palpa_file, length_unit_assumed);
  FIELD(palpa_file, format);
  FIELD(palpa_file, modality);
  FIELD(palpa_file, length_unit);
  FIELD(palpa_file, fields);
  FIELD(palpa_file, field_count);
  FIELD(palpa_file, sources);
  FIELD(palpa_file, source_count);
  END(palpa_file);
  BEGIN(palpa_primitive);
  FIELD(palpa_primitive, size);
  FIELD(palpa_primitive, kind);
  FIELD(palpa_primitive, mode);
  FIELD(palpa_primitive, unused);
  FIELD(palpa_primitive, position_m);
  FIELD(palpa_primitive, direction);
  FIELD(palpa_primitive, strength_n);
  FIELD(palpa_primitive, force_n);
  END(palpa_primitive);
  BEGIN(palpa_steering);
  FIELD(palpa_steering, size);
  FIELD(palpa_steering, buttons);
  FIELD(palpa_steering, way_m);
  FIELD(palpa_steering, deflection);
  FIELD(palpa_steering, is_put);
  FIELD(palpa_steering, unused);
  FIELD(palpa_steering, put_m);
  END(palpa_steering);
  if (gaps) fprintf(stderr, "%d gaps\n", gaps);
  return gaps != 0;
}
