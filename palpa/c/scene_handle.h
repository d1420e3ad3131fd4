// The handle of a scene for C.
#pragma once

#include "palpa/c/scene_recipe.h"

struct palpa_scene {
  palpa::c::SceneRecipe recipe;
};
