// Functions for C of sessions.
#include "palpa/session/session.h"

#include <algorithm>
#include <cmath>

#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/c/scene_handle.h"
#include "palpa/c/session_values.h"
#include "palpa/c/sized.h"
#include "palpa/data/octaves.h"

struct palpa_session {
  palpa::Session session;
};

namespace palpa::c {
namespace {

/// Fault of a tick's pointers and sizes, half a sentence; nullptr: none.
const char* problem_with(const palpa_session* session, const palpa_probe* probe, const palpa_tick* out) noexcept {
  if (!session) return "session is NULL; give one";
  if (!probe) return "probe is NULL; give one";
  if (!out) return "out is NULL; give a place for the tick";
  if (!is_known_size<palpa_probe>(probe->size)) return "size of the probe is wrong; set it to sizeof(palpa_probe)";
  if (!is_known_size<palpa_tick>(out->size)) return "size of out is wrong; set it to sizeof(palpa_tick)";
  return nullptr;
}

}  // namespace
}  // namespace palpa::c

using namespace palpa::c;

extern "C" {

palpa_session* palpa_session_new(const palpa_scene* scene, double encoder_step_m) {
  return pointer_of("palpa_session_new", [&] {
    const palpa::Scene& felt = given(scene, "scene").recipe.scene();
    if (!std::isfinite(encoder_step_m) || encoder_step_m < 0.0)
      throw WrongArgument("encoder_step_m is below 0 or not finite; 0 is a device without steps");
    auto session = std::make_unique<palpa_session>(palpa::Session(felt, encoder_step_m));
    if (!session->session.stock().empty())
      throw WrongArgument("the scene has a volume larger than memory; choose a coarser file, or raise 'memory_mb'");
    return session.release();
  });
}

void palpa_session_free(palpa_session* session) { delete session; }

palpa_result palpa_session_tick(palpa_session* session, const palpa_probe* probe, double time_step_s, palpa_tick* out) {
  constexpr const char* place = "palpa_session_tick";
  if (const char* problem = problem_with(session, probe, out)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  const palpa::Tick tick = session->session.tick(probe_of(whole(probe)), time_step_s);
  put(tick_of(tick), out->size, out);
  if (!(time_step_s > 0.0 && time_step_s <= 1.0))
    return fail(PALPA_WRONG_ARGUMENT, place, "time_step_s is out of its range; it is above 0 and at most 1");
  if (tick.status == palpa::TickStatus::bad_input)
    return fail(PALPA_WRONG_ARGUMENT, place,
                "the probe cannot be used; it has finite numbers, a position within 1000 m and, for a tool, a unit quaternion");
  return PALPA_OK;
}

palpa_result palpa_session_take_over(palpa_session* session, const palpa_session* other) {
  if (!session || !other) return fail(PALPA_WRONG_ARGUMENT, "palpa_session_take_over", "a session is NULL; give both");
  if (session != other) session->session.resume_in_changed_scene(other->session);
  return PALPA_OK;
}

void palpa_session_reset(palpa_session* session) {
  if (session) session->session.reset();
}

size_t palpa_session_events(const palpa_session* session, palpa_event* out, size_t room) {
  constexpr const char* place = "palpa_session_events";
  if (!session) return fail(0, place, "session is NULL; give one"), std::size_t{0};
  return put_events(place, session->session, out, room);
}
}
