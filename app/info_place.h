// Places in data in the forms that people write: `--at`.
#pragma once

#include <string>

#include "app/info_facts.h"

namespace palpa::app {

/// A place as the user gave it.
struct AskedPlace {
  enum class In {
    grid,     ///< `at` are voxel indices
    world,    ///< `at` is in metres of the world
    patient,  ///< `at` is in metres to the patient's left, back and head
  };
  In in = In::world;
  Vec3 at;
  std::string text;  ///< as it was written
};

/// Reads a place: `120,200,90` is a voxel, counted from 0; `-5mm,16mm,7mm` a position in the world (a unit behind the last
/// number alone is that of all three); `R5,A16,S7` a position in the patient: one of R or L, one of A or P, one of S or I, in
/// millimetres if no unit is given. Throws LoadError.
AskedPlace asked_place(const std::string& text);
/// Reads a place such as `0.01,-0.05,0`, in metres of the world. Throws LoadError.
AskedPlace asked_place_m(const std::string& text);

/// The place in the world [m]. Throws LoadError where the data do not say how the patient lies.
Vec3 world_of(const AskedPlace& place, const Facts& facts);

/// The place on the first field's grid.
GridPoint voxel_of(const Facts& facts, const Vec3& world_m);

/// The place in words: "R 5.0, A 16.0, S 7.0 mm" in a patient, "(0.1, 0, 0.2) m" elsewhere.
std::string format_place(const Facts& facts, const Vec3& world_m);
/// The extent of a box in words: "R 115.5 to L 115.0, A 1.9 to P 228.7, S 696.2 to S 831.2 mm".
std::string format_place(const Facts& facts, const Box& box_m);

/// A sentence for a place outside of all data: how far outside, and whether another unit may have been meant.
std::string why_outside(const AskedPlace& place, const Facts& facts, const Vec3& world_m);

}  // namespace palpa::app
