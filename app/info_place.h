// Places of data as people write them: `--at`.
#pragma once

#include <string>

#include "app/info_facts.h"

namespace palpa::app {

/// A place as it is asked for.
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

/// `120,200,90` is a voxel, counted from 0; `-5mm,16mm,7mm` a position of the world, one unit behind the last number being that
/// of all; `R5,A16,S7` one of the patient: each of R or L, A or P, S or I once, millimetres where no unit is said. Throws
/// LoadError.
AskedPlace asked_place(const std::string& text);
/// `0.01,-0.05,0` in metres of the world. Throws LoadError.
AskedPlace asked_place_m(const std::string& text);

/// The place in the world [m]. Throws LoadError where the data do not say how the patient lies.
Vec3 world_of(const AskedPlace& place, const Facts& facts);

/// The place on the first field's grid.
GridPoint voxel_of(const Facts& facts, const Vec3& world_m);

/// The place as one would say it: "R 5.0, A 16.0, S 7.0 mm" of a patient, "(0.1, 0, 0.2) m" elsewhere.
std::string words_of(const Facts& facts, const Vec3& world_m);
/// From where to where a box reaches: "R 115.5 to L 115.0, A 1.9 to P 228.7, S 696.2 to S 831.2 mm".
std::string words_of(const Facts& facts, const Box& box_m);

/// What is to be said of a place that is outside of all data: how far, and whether another unit was meant.
std::string why_outside(const AskedPlace& place, const Facts& facts, const Vec3& world_m);

}  // namespace palpa::app
