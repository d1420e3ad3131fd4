// Scenes that use every part of a tick.
#pragma once

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"

namespace palpa::test {

/// A head with elastic skin and rigid bone, in a followed flow.
inline Scene busy_scene(bool as_grid) {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
  const auto data = [&](const Volume& volume) { return as_grid ? sampled(volume, 48) : volume; };
  const FieldRef head = scene.add("head", data(head_phantom()));
  const FieldRef flow = scene.add("flow", data(burgers_vortex()), {.scale = 4.0});
  scene.add(
      "skin",
      SurfaceAndFriction{
          .field = head,
          .levels = {{.name = "skin", .value = -300, .strength_n = 0.8, .stiffness_n_per_m = 300, .friction_coefficient = 0.3},
                     {.name = "bone", .value = 300, .strength_n = 4.0, .friction_n = 0.2}},
          .texture_ratio = 0.5});
  scene.add("rail", Follow{.field = flow, .strength_n = 0.4, .drag_ns_per_m = 1.0});
  scene.add(
      "air",
      Viscosity{.field = head, .strength_n = {head, TransferFunction({{-1100, 0.1}, {-500, 0.0}})}, .drag_ns_per_m = 0.5});
  return scene;
}

/// With a moving head that jumps back at its loop's start, and a beating heart: levels are carried, fade out and in.
inline Scene busy_moving_scene(bool as_grid) {
  Scene scene = busy_scene(as_grid);
  const FieldRef other = scene.add_moving("other", as_grid ? sampled(head_phantom(), 48) : head_phantom(),
                                          {{0.0, {}}, {0.03, {Mat3::identity(), 1.01, {0.001, 0.002, 0.0}}}});
  scene.add("heart", sampled(beating_chamber(), 33, 10), {.scale = 3.0});
  scene.add("moving_skin", SurfaceAndFriction{.field = other,
                                              .levels = {{.name = "skin", .value = -300, .strength_n = 20.0}},
                                              .friction_coefficient = 0.3,
                                              .texture_ratio = 1.0});
  scene.add("wall", SurfaceAndFriction{.field = {"heart.signal"},
                                       .levels = {{.name = "wall", .value = 0.5, .strength_n = 0.8, .stiffness_n_per_m = 500}},
                                       .friction_n = 0.2});
  scene.edit<TimeOptions>([&](auto& time) { time.play = TimeOptions::Play::loop; });
  return scene;
}

}  // namespace palpa::test
