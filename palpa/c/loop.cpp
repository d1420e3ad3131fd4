// Functions for C of a session with the guard, and of its recording.
#include "palpa/loop/loop.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "palpa/base/wording.h"
#include "palpa/c.h"
#include "palpa/c/device_limits.h"
#include "palpa/c/failure.h"
#include "palpa/c/scene_handle.h"
#include "palpa/c/session_values.h"
#include "palpa/c/sized.h"
#include "palpa/data/octaves.h"
#include "palpa/loop/clutch_mapping.h"
#include "palpa/version.h"

namespace palpa::c {
namespace {

/// A scene as it is felt, within the limits of the device.
struct Felt {
  Felt(const SceneRecipe& of, const DeviceLimits& limits)
      : recipe(of), scene(clamped_to(of.scene(), limits)), session(scene, limits.encoder_step_m) {
    if (!session.stock().empty())
      throw WrongArgument("the scene has a volume larger than memory; choose a coarser file, or raise 'memory_mb'");
  }

  SceneRecipe recipe;
  Scene scene;
  Session session;
};

/// Files of a trace, open while ticks are recorded.
struct Recording {
  Recording(const std::filesystem::path& folder, const TraceHeader& header, const std::string& text,
            std::vector<std::string> modes)
      : writer(folder, header, text, std::move(modes)), recorder(writer) {}

  TraceWriter writer;
  Recorder recorder;
  bool lost = false;  // a tick had no room
};

TraceHeader header_of(const Felt& felt, const DeviceLimits& limits, std::uint32_t dead_man_buttons) {
  TraceHeader header;
  header.palpa_version = version;
  header.sets = felt.recipe.sets();
  for (const TakenLimit& limit : taken_limits(felt.recipe.scene(), felt.scene)) {
    header.sets.emplace_back(limit.path, detail::toml_number(limit.value));
    header.notes.push_back(limit.sentence);
  }
  header.hand_to_world = felt.scene.hand_to_world();
  header.device_max_force_n = limits.max_force_n;
  header.device_max_stiffness_n_per_m = limits.max_stiffness_n_per_m;
  header.device_workspace_radius_m = limits.workspace_radius_m;
  header.device_encoder_step_m = limits.encoder_step_m;
  header.device_continuous_force_n = limits.continuous_force_n;
  header.device_max_damping_ns_per_m = limits.max_damping_ns_per_m;
  header.device_damping_ns_per_m = limits.damping_ns_per_m;
  header.dead_man_buttons = dead_man_buttons;
  header.motors = limits.has_motors;
  header.primitives = true;
  header.has_tool = !Tool(felt.scene.tool(), felt.scene.coupling()).is_point();
  for (const SceneVolume& volume : felt.scene.volumes())
    header.data_files.insert(header.data_files.end(), volume.volume.files.begin(), volume.volume.files.end());
  return header;
}

DeviceState state_of(const Probe& probe) noexcept {
  return {.position_m = probe.position_m,
          .velocity_m_per_s = probe.velocity_m_per_s,
          .valid = probe.valid,
          .buttons = probe.buttons,
          .turn = probe.turn};
}

/// \param force_n  of the command, along the axes of the device
palpa_command command_of(const TickFrame& frame, const Vec3& force_n, bool brakes) noexcept {
  palpa_command out{};
  out.guard = static_cast<std::int32_t>(frame.command.guard);
  out.cause = static_cast<std::int32_t>(frame.command.cause);
  out.brakes = brakes;
  put_vector(out.force_n, force_n);
  put_vector(out.coupling_n, frame.result.force_n);
  put_vector(out.proxy_m, frame.result.proxy_m);
  return out;
}

palpa_primitive primitive_of(const PlacedPrimitive& placed) noexcept {
  palpa_primitive out{};
  out.kind = static_cast<std::int32_t>(placed.primitive.kind);
  out.mode = placed.primitive.id.mode;
  put_vector(out.position_m, placed.primitive.position_m);
  put_vector(out.direction, placed.primitive.direction);
  out.strength_n = placed.primitive.strength_n;
  put_vector(out.force_n, placed.force_n);
  return out;
}
static_assert(static_cast<int>(PrimitiveKind::corner) == 4);
static_assert(bit_of(Circumstance::resume) == PALPA_RESUME && bit_of(Circumstance::device_fault) == PALPA_DEVICE_FAULT);

}  // namespace
}  // namespace palpa::c

struct palpa_loop {
  palpa_loop(const palpa::c::SceneRecipe& recipe, const palpa::DeviceLimits& given, std::uint32_t dead_man)
      : limits(given),
        dead_man_buttons(dead_man),
        felt(std::make_unique<palpa::c::Felt>(recipe, limits)),
        guarded(std::make_unique<palpa::GuardedSession>(felt->session, options())) {}

  palpa::GuardOptions options() const {
    palpa::GuardOptions made = guard_options_for(limits, felt->scene.coupling().max_force_n);
    made.motors = limits.has_motors;
    made.dead_man_buttons = dead_man_buttons;
    return made;
  }

  palpa::DeviceLimits limits;
  std::uint32_t dead_man_buttons;
  std::unique_ptr<palpa::c::Felt> felt, before;  // before: felt until the next tick, after a change
  std::unique_ptr<palpa::GuardedSession> guarded;
  palpa::ClutchMapping grip{{}};
  std::unique_ptr<palpa::c::Recording> recording;
  std::int64_t ticks = 0;
  double t_s = 0.0;
  bool has_new_scene = false;
};

using namespace palpa::c;

extern "C" {

palpa_loop* palpa_loop_new(const palpa_scene* scene, const palpa_limits* limits) {
  return pointer_of("palpa_loop_new", [&] {
    if (!is_known_size<palpa_limits>(given(limits, "limits").size))
      throw WrongArgument("size of the limits is wrong; set it to sizeof(palpa_limits)");
    const palpa_limits all = whole(limits);
    return new palpa_loop(given(scene, "scene").recipe, limits_of(all), all.dead_man_buttons);
  });
}

void palpa_loop_free(palpa_loop* loop) { delete loop; }

palpa_result palpa_loop_tick(palpa_loop* loop, const palpa_probe* probe, double time_step_s, uint32_t circumstances,
                             palpa_command* command, palpa_tick* tick) {
  constexpr const char* place = "palpa_loop_tick";
  constexpr std::uint32_t known = 2 * PALPA_RESUME - 1;
  if (!loop) return fail(PALPA_WRONG_ARGUMENT, place, "loop is NULL; give one");
  if (!command || !is_known_size<palpa_command>(command->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "command is NULL or of a wrong size; give a place with size set");
  if (tick && !is_known_size<palpa_tick>(tick->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "size of tick is wrong; set it to sizeof(palpa_tick)");
  const bool is_known_probe = probe && is_known_size<palpa_probe>(probe->size);
  const bool has_time = time_step_s > 0.0 && time_step_s <= 1.0;
  palpa::Probe taken{.valid = false};
  if (is_known_probe && has_time) taken = probe_of(whole(probe));
  std::uint32_t bits = circumstances & known;
  if (std::exchange(loop->has_new_scene, false)) bits |= bit_of(palpa::Circumstance::new_scene);
  // A step that cannot be used stands for a short one: the guard's clock goes on.
  const double dt_s = has_time ? time_step_s : 1e-3;
  const palpa::ClutchMapping::Held held = loop->grip.hold(state_of(taken), dt_s);
  if (held.moves) bits |= bit_of(palpa::Circumstance::view_moves);
  const palpa::TickFrame frame = loop->guarded->tick(loop->ticks, loop->t_s, dt_s, held.probe, bits);
  if (loop->recording && !loop->recording->recorder.offer(frame, loop->guarded->session())) loop->recording->lost = true;
  ++loop->ticks;
  loop->t_s += dt_s;
  const palpa::Wrench sent = loop->grip.at_device({frame.command.force_n, frame.command.torque_nm});
  put(command_of(frame, sent.force_n, loop->guarded->brakes()), command->size, command);
  if (tick) put(tick_of(frame.result), tick->size, tick);
  if (!is_known_probe || !has_time || frame.result.status == palpa::TickStatus::bad_input)
    return fail(
        PALPA_WRONG_ARGUMENT, place,
        "the probe or the time step cannot be used; give a probe with size set and finite numbers, and a step above 0, at "
        "most 1");
  return PALPA_OK;
}

palpa_result palpa_loop_turn(palpa_loop* loop, const double rotation[9]) {
  constexpr const char* place = "palpa_loop_turn";
  if (!loop || !rotation) return fail(PALPA_WRONG_ARGUMENT, place, "loop or rotation is NULL; give both");
  const palpa::Mat3 turn{{{rotation[0], rotation[1], rotation[2]},
                          {rotation[3], rotation[4], rotation[5]},
                          {rotation[6], rotation[7], rotation[8]}}};
  if (!is_usable(palpa::Similarity{.rotation = turn}))
    return fail(PALPA_WRONG_ARGUMENT, place, "rotation is none; give 9 numbers by row, orthonormal and not a mirror");
  loop->grip.turn(turn);
  return PALPA_OK;
}

palpa_result palpa_loop_change(palpa_loop* loop, const palpa_scene* scene) {
  return result_of("palpa_loop_change", [&] {
    given(loop, "loop");
    auto next = std::make_unique<Felt>(given(scene, "scene").recipe, loop->limits);
    // The session that is felt until the next tick, also after several changes.
    if (!loop->has_new_scene) loop->before = std::move(loop->felt);
    next->session.resume_in_changed_scene(loop->before->session);
    loop->guarded->switch_to(next->session, palpa::Tool(next->scene.tool(), next->scene.coupling()));
    loop->felt = std::move(next);
    loop->has_new_scene = true;
  });
}

size_t palpa_loop_events(const palpa_loop* loop, palpa_event* out, size_t room) {
  constexpr const char* place = "palpa_loop_events";
  if (!loop) return fail(0, place, "loop is NULL; give one"), std::size_t{0};
  return put_events(place, loop->guarded->session(), out, room);
}

size_t palpa_loop_primitives(const palpa_loop* loop, palpa_primitive* out, size_t room) {
  constexpr const char* place = "palpa_loop_primitives";
  if (!loop) return fail(0, place, "loop is NULL; give one"), std::size_t{0};
  const auto placed = loop->guarded->session().primitives();
  if (!out || room == 0) return placed.size();
  const std::uint32_t size = out->size;
  if (!is_known_size<palpa_primitive>(size))
    return fail(0, place, "size of the first primitive is wrong; set it to sizeof(palpa_primitive)"), std::size_t{0};
  auto* to = reinterpret_cast<std::byte*>(out);
  for (const palpa::PlacedPrimitive& one : placed.first(std::min(room, placed.size()))) {
    put(primitive_of(one), size, to);
    to += size;
  }
  return placed.size();
}

palpa_result palpa_loop_mode(const palpa_loop* loop, int32_t mode, double force_n[3]) {
  constexpr const char* place = "palpa_loop_mode";
  if (!loop || !force_n) return fail(PALPA_WRONG_ARGUMENT, place, "loop or force_n is NULL; give both");
  const auto modes = loop->guarded->session().modes();
  if (mode < 0 || static_cast<std::size_t>(mode) >= modes.size())
    return fail(PALPA_WRONG_ARGUMENT, place, "mode is no number of a mode of the scene; they begin at 0");
  const palpa::Vec3& force = modes[static_cast<std::size_t>(mode)].force_n;
  force_n[0] = force.x, force_n[1] = force.y, force_n[2] = force.z;
  return PALPA_OK;
}

palpa_result palpa_loop_record(palpa_loop* loop, const char* folder, double least_time_step_s, const char* device) {
  return result_of("palpa_loop_record", [&] {
    given(loop, "loop");
    if (!folder) {
      if (!loop->recording) throw WrongArgument("nothing is recorded; begin with a folder");
      const auto ended = std::move(loop->recording);
      ended->recorder.finish();
      if (ended->lost) ended->writer.add_note("Some ticks had no room in the recorder and are missing.");
      ended->writer.finish();
      return;
    }
    if (loop->recording) throw WrongArgument("a recording goes on already; end it first");
    if (!(least_time_step_s > 0.0 && least_time_step_s <= 1.0))
      throw WrongArgument("least_time_step_s is out of its range; it is above 0 and at most 1");
    palpa::TraceHeader header = header_of(*loop->felt, loop->limits, loop->dead_man_buttons);
    header.dt_s = least_time_step_s;
    header.device_name = device ? device : "";
    std::vector<std::string> modes;
    for (const palpa::SceneMode& mode : loop->felt->scene.modes()) modes.push_back(mode.name);
    loop->recording = std::make_unique<Recording>(folder, header, loop->felt->recipe.text(), std::move(modes));
    loop->ticks = 0;
    loop->t_s = 0.0;
    // A trace begins with a session at rest, as its replay does.
    auto fresh = std::make_unique<Felt>(loop->felt->recipe, loop->limits);
    loop->guarded = std::make_unique<palpa::GuardedSession>(fresh->session, loop->options());
    loop->felt = std::move(fresh);
    loop->before.reset();
    loop->has_new_scene = false;
  });
}
}
