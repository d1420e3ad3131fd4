#include "palpa/c/session_values.h"

#include <algorithm>

#include "palpa/c/failure.h"
#include "palpa/c/sized.h"

namespace palpa::c {
namespace {

void put_turn(double (&to)[4], const Turn& turn) noexcept { to[0] = turn.w, to[1] = turn.x, to[2] = turn.y, to[3] = turn.z; }

palpa_event event_of(const SessionEvent& event) noexcept {
  palpa_event out{};
  out.kind = static_cast<std::int32_t>(event.kind);
  out.mode = event.mode;
  out.value = event.value;
  out.depth_m = event.depth_m;
  copy_utf8(event.text ? event.text : "", out.text);
  return out;
}

}  // namespace

void put_vector(double (&to)[3], const Vec3& v) noexcept { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

Probe probe_of(const palpa_probe& given) noexcept {
  const auto& [x, y, z] = given.position_m;
  const auto& [vx, vy, vz] = given.velocity_m_per_s;
  const auto& [w, qx, qy, qz] = given.turn;
  Probe probe{.position_m = {x, y, z}, .valid = given.valid != 0, .buttons = given.buttons, .turn = {w, qx, qy, qz}};
  if (given.has_velocity != 0) probe.velocity_m_per_s = Vec3{vx, vy, vz};
  return probe;
}

palpa_tick tick_of(const Tick& tick) noexcept {
  palpa_tick out{};
  out.status = static_cast<std::int32_t>(tick.status);
  put_vector(out.force_n, tick.force_n);
  put_vector(out.proxy_m, tick.proxy_m);
  put_vector(out.proxy_velocity_m_per_s, tick.proxy_velocity_m_per_s);
  put_vector(out.probe_m, tick.probe_m);
  put_vector(out.probe_velocity_m_per_s, tick.probe_velocity_m_per_s);
  put_vector(out.probe_step_m, tick.probe_step_m);
  out.error_bound_m = tick.error_bound_m;
  out.given_back_n = tick.given_back_n;
  out.unborne_n = tick.unborne_n;
  out.felt_octave = tick.felt_octave;
  out.probe_valid = tick.probe_valid;
  out.forced_octave = tick.forced_octave;
  out.sub_steps = tick.sub_steps;
  out.iterations = tick.iterations;
  out.dropped = tick.dropped;
  out.work = tick.work;
  out.stored_j = tick.energy.stored_j;
  out.elastic_j = tick.energy.elastic_j;
  out.dissipated_j = tick.energy.dissipated_j;
  out.injected_j = tick.energy.injected_j;
  out.path_and_release_j = tick.energy.path_and_release_j;
  out.damper_j = tick.energy.damper_j;
  out.data_motion_j = tick.energy.data_motion_j;
  out.released_j = tick.energy.released_j;
  out.sampling_j = tick.energy.sampling_j;
  out.sampling_bound_j = tick.energy.sampling_bound_j;
  put_vector(out.torque_nm, tick.torque_nm);
  put_turn(out.probe_turn, tick.probe_turn);
  put_turn(out.proxy_turn, tick.proxy_turn);
  put_vector(out.probe_turn_step_rad, tick.probe_turn_step_rad);
  return out;
}

size_t put_events(const char* place, const Session& session, palpa_event* out, std::size_t room) noexcept {
  const auto events = session.events();
  if (!out || room == 0) return events.size();
  const std::uint32_t size = out->size;
  if (!is_known_size<palpa_event>(size))
    return fail(0, place, "size of the first event is wrong; set it to sizeof(palpa_event)"), std::size_t{0};
  auto* to = reinterpret_cast<std::byte*>(out);
  for (const SessionEvent& event : events.first(std::min(room, events.size()))) {
    put(event_of(event), size, to);
    to += size;
  }
  return events.size();
}

}  // namespace palpa::c
