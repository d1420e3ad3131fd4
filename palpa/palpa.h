// All of the library but devices, pictures and reports.
#pragma once

#include "palpa/core/solver.h"
#include "palpa/device/hand.h"
#include "palpa/field/analytic.h"
#include "palpa/field/grid.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/follow.h"
#include "palpa/mode/mode.h"
#include "palpa/mode/surface_and_friction.h"
#include "palpa/mode/viscosity.h"
#include "palpa/scene/load_scene.h"
#include "palpa/scene/scene.h"
#include "palpa/study/run.h"
#include "palpa/study/summary.h"
#include "palpa/tick/session.h"
#include "palpa/version.h"
#include "palpa/volume/read_volume.h"
