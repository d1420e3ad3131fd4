// Scenes and sessions: data, modes, a scene made of them, and what a hand feels of it. Devices and the loop, traces, pictures
// and reports have headers of their own.
#pragma once

#include "palpa/core/solver.h"
#include "palpa/file/read_volume.h"
#include "palpa/grid/grid.h"
#include "palpa/mode/mode.h"
#include "palpa/mode/modes.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/load_scene.h"
#include "palpa/scene/scene.h"
#include "palpa/tick/session.h"
#include "palpa/time/timed_field.h"
#include "palpa/version.h"
#include "palpa/volume/analytic.h"
