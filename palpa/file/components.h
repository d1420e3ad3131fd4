// Vectors with each component in an array of its own: u, v, w.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/file/protocol.h"

namespace palpa {

/// Triples of scalar fields that are components of a vector by name: `u v w`, `vx vy vz`, `velocity_x velocity_y velocity_z`,
/// `wind:0 wind:1 wind:2` and similar, in upper or lower case, on one grid. The vector has the common part as its name, or
/// "velocity" if that is empty or a letter.
std::vector<VolumeRequest::FieldRequest> separate_vectors(const Volume& volume);

/// Request for these vectors as single fields, and for all other fields; none if a file has no such triple, or the request
/// names its fields.
std::optional<VolumeRequest> with_vectors_joined(const VolumeRequest& request, const Volume& volume);

namespace detail {

/// Reason why arrays cannot be the components of one vector, as a half sentence; nullptr if they can, or for a single array.
const char* problem_with_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays);

/// Voxels of vectors from their three components, float64 if a component needs it, else float32. Allocates.
Voxels joined_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays,
                         const std::vector<std::shared_ptr<const void>>& voxels);

/// Joint resampling of the fields `parts`: concatenated ranges, the worse of the errors.
Resampling joined_resampling(const std::vector<Resampling>& all, const std::vector<std::size_t>& parts);

}  // namespace detail
}  // namespace palpa
