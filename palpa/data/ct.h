// What the numbers of a CT scan say: where water is, and which part of them a radiologist looks at.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "palpa/data/statistics.h"

namespace palpa {

/// The value of water where the values of a scalar field are those of a CT scan: 0 in Hounsfield units (looks_like_hounsfield),
/// 1024 where a file lacks that offset: air near 0, and beyond a valley a peak of tissue about 1024. Nothing elsewhere. In the
/// field's own unit. \param modality  as Volume::modality
std::optional<double> ct_water(const Statistics& values, const std::string& unit, const std::string& modality = {});

/// A stretch of the values of a CT, from black to white.
struct CtWindow {
  const char* name;    ///< "brain", "soft tissue", "bone", "lung"
  double level = 0.0;  ///< [HU] its middle
  double width = 0.0;  ///< [HU]
};

/// The window in which most is seen: that of the part of the body where enough of what is denser than air lies in it, else one
/// that the values ask for.
/// \param water      as ct_water, in the field's own unit
/// \param body_part  as ScanFactKind::body_part; empty where the file does not say it
/// \param widest_m   [m] longest side of the data: a head fits into less than 0.32 m
CtWindow ct_window(const Statistics& values, double water, std::string_view body_part, double widest_m);

}  // namespace palpa
