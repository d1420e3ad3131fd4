// Random scenes: every mode, any parameters, grids of every type and content.
#pragma once

#include "palpa/scene/scene.h"
#include "tests/fuzz/choices.h"

namespace palpa::fuzz {

/// A number for a hand, a voxel or a time: about `usual` [1], or an extreme number.
double odd_number(Choices& choices, double usual);

/// A tool of any shape, of up to 256 feet, and the turning parts of the coupling. Throws SceneError.
void set_random_tool(Choices& choices, Scene& scene);

/// A scene of one to three volumes and one to five modes. Throws SceneError, as a program's own scene would.
Scene random_scene(Choices& choices);

}  // namespace palpa::fuzz
