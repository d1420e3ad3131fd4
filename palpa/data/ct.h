// CT values: the offset of water, and the radiological window.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "palpa/data/statistics.h"

namespace palpa {

/// Value of water in a scalar field of CT values: 0 in Hounsfield units (looks_like_hounsfield), 1024 in files without that
/// offset: air near 0, and beyond a valley a peak of tissue about 1024. None for other data. In the field's own unit.
/// \param modality  as Volume::modality
std::optional<double> ct_water(const Statistics& values, const std::string& unit, const std::string& modality = {});

/// Interval of CT values, from black to white.
struct CtWindow {
  const char* name;    ///< "brain", "soft tissue", "bone", "lung"
  double level = 0.0;  ///< [HU] centre
  double width = 0.0;  ///< [HU]
};

/// Window of the most visible content: of the file's part of the body if enough of the values denser than air lie in it, else
/// chosen by the values.
/// \param water      as ct_water, in the field's own unit
/// \param body_part  as ScanFactKind::body_part; empty if unknown
/// \param widest_m   [m] longest side of the data: a head fits into less than 0.32 m
CtWindow ct_window(const Statistics& values, double water, std::string_view body_part, double widest_m);

}  // namespace palpa
