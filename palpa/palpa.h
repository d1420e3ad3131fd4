// Scenes and sessions: data, modes, a scene made of them, and what a hand feels of it. Devices and the loop, traces, pictures
// and reports have headers of their own.
#pragma once

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/mode.h"
#include "palpa/mode/modes.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/load_scene.h"
#include "palpa/scene/scene.h"
#include "palpa/session/session.h"
#include "palpa/solver/solver.h"
#include "palpa/version.h"
