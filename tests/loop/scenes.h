// A small scene and a temporary folder for the tests of the loop.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/scene.h"

namespace palpa::test {

/// The head phantom with skin and bone, in a viscous medium.
inline Scene head_scene() {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
  const FieldRef head = scene.add("head", head_phantom());
  scene.add("skin",
            SurfaceAndFriction{.field = head,
                               .levels = {{.name = "skin", .value = -300, .strength_n = 0.8, .friction_coefficient = 0.3},
                                          {.name = "bone", .value = 300, .strength_n = 4.0, .friction_n = 0.2}}});
  scene.add("syrup", Viscosity{.field = head, .strength_n = {0.05}, .drag_ns_per_m = 0.2});
  return scene;
}

class InFolder : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-loop-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(root_); }
  std::filesystem::path folder(const std::string& name) const { return root_ / name; }

 private:
  std::filesystem::path root_;
};

}  // namespace palpa::test
