// All of the component `vtk`: data and functions from VTK and back, and a live scene in anybody's window.
#pragma once

#include "palpa/vtk/felt_actors.h"
#include "palpa/vtk/felt_tool.h"
#include "palpa/vtk/from_vtk.h"
#include "palpa/vtk/mouse_pointer.h"
#include "palpa/vtk/to_vtk.h"
