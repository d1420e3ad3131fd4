// Probes, ticks and events of a session, for C and of C.
#pragma once

#include <cstddef>
#include <span>

#include "palpa/c.h"
#include "palpa/session/session.h"

namespace palpa::c {

// None allocates; any thread.

/// \param v  in its own unit
void put_vector(double (&to)[3], const Vec3& v) noexcept;
Probe probe_of(const palpa_probe& given) noexcept;
palpa_tick tick_of(const Tick& tick) noexcept;
/// Writes the first `room` events of a session, each with the size of the first. Returns the number of all; 0 with a new
/// sentence for a wrong size.
/// \param place  name of the function
size_t put_events(const char* place, const Session& session, palpa_event* out, std::size_t room) noexcept;

}  // namespace palpa::c
