// The scene of docs_test.py in C++: prints it as TOML, runs and records it.
//   python_same_scene FOLDER TRACE     with FOLDER/ramp.raw
#include <palpa/palpa.h>

#include <cstdio>

#include "palpa/study/run.h"

int main(int, char** arguments) {
  const std::filesystem::path folder = arguments[1];
  palpa::Scene scene({.stiffness_n_per_m = 500, .damping_ns_per_m = 0.25});
  scene.title = "a ramp";
  palpa::VolumeRequest request;
  request.files = {folder / "ramp.raw"};
  request.layout.type = "int16";
  request.layout.dims = {12, 12, 12};
  request.layout.spacing_m = {0.001, 0.002, 0.003};
  const auto ramp = scene.add("ramp", palpa::read_volume(request));
  scene.edit<palpa::Workspace>([&](auto& workspace) {
    workspace.scale = 0.25;
    workspace.up = "-y";
  });
  scene.add("wall", palpa::SurfaceAndFriction{
                        .field = ramp,
                        .solid = palpa::SurfaceAndFriction::Solid::low,
                        .levels = {{.name = "zero", .value = 0, .strength_n = 2},
                                   {.value = 6,
                                    .strength_n = palpa::Strength({"gradient_magnitude(ramp)"},
                                                                  palpa::TransferFunction({{0, 1}, {2000, 3}}, 3))}},
                        .friction_n = 0.2});
  scene.add("syrup", palpa::Viscosity{.drag_ns_per_m = 1}, {{ramp, palpa::TransferFunction({{-16, 0}, {16, 1}})}}, false);

  const std::string text = to_toml(scene);
  std::fputs(text.c_str(), stdout);
  palpa::RunOptions options;
  options.hand = "sim:press";
  options.duration_s = 1;
  options.out = arguments[2];
  options.primitives = true;
  palpa::run(palpa::prepare({scene, text, scene.check()}, options), options);
}
