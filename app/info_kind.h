// What kind of data a file holds, in words of people who use such data.
#pragma once

#include <string>

#include "app/info_facts.h"
#include "palpa/data/labels.h"
#include "palpa/data/volume.h"

namespace palpa::app {

/// What the file holds: "CT, head, in Hounsfield units", "CFD: velocity, pressure and mach". Taken from what the file says of
/// itself; what only its values, the names of its arrays or its own name suggest is marked by "looks like".
std::string kind_of(const Facts& facts);

/// Whether it is a scan of a body, by the same signs as `kind_of`, even if the file does not say how a patient lies in it.
bool looks_like_scan(const Facts& facts);

/// [deg] What is sheared by less is only rounded.
inline constexpr double least_shear_deg = 0.1;
/// "gantry tilt of 18.5°", by which the slices of a CT are sheared; empty where they are not.
std::string gantry_tilt(const Facts& facts);

/// A fact of a scan's acquisition in a form for fmt; empty if the file has none.
std::string scan_fact(const Volume& volume, ScanFactKind kind, const char* form = "{}");

/// The field as a label map; without labels if it is none, or if not all of its voxels were looked at.
LabelMap labels_in(const Volume& volume, const VolumeField& field, const Statistics& values);

}  // namespace palpa::app
