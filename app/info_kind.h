// What a file is, in words that its reader uses.
#pragma once

#include <string>

#include "app/info_facts.h"
#include "palpa/survey/labels.h"
#include "palpa/volume/volume.h"

namespace palpa::app {

/// What the file holds: "CT, head, in Hounsfield units", "CFD: velocity, pressure and mach". By what the file says of itself;
/// what its values, the names of its arrays or its own name make likely is said as "looks like".
std::string kind_of(const Facts& facts);

/// Whether it is a scan of a body by what `kind_of` goes by, though the file may not say how a patient lies in it.
bool looks_like_scan(const Facts& facts);

/// The label map that a scalar field is; without labels where it is none, or too large to be looked at as a whole.
LabelMap labels_in(const VolumeField& field, const Statistics& values);

}  // namespace palpa::app
