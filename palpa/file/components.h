// Vectors whose components a file has as arrays of their own: u, v, w.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/file/protocol.h"

namespace palpa {

/// Three scalar fields of a volume whose names say that they are the components of one vector: `u v w`, `vx vy vz`,
/// `velocity_x velocity_y velocity_z`, `wind:0 wind:1 wind:2` and the like, in upper or lower case, on one grid.
/// The vector's name is what they have in common, or "velocity" where that is nothing or a letter.
std::vector<VolumeRequest::FieldRequest> separate_vectors(const Volume& volume);

/// The request that reads those vectors, each as one field, and the other fields as they are; nothing where a file has none, or
/// the request says itself what its fields are.
std::optional<VolumeRequest> with_vectors_joined(const VolumeRequest& request, const Volume& volume);

namespace detail {

/// Why arrays cannot be the components of one vector, as a half sentence; nullptr where they can, or are one alone.
const char* problem_with_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays);

/// Voxels of vectors from those of their three components, float64 where a component needs it, else float32. Allocates.
Voxels joined_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays,
                         const std::vector<std::shared_ptr<const void>>& voxels);

/// What is known of the resampling of fields `parts` together: ranges one after the other, the worse of their errors.
Resampling joined_resampling(const std::vector<Resampling>& all, const std::vector<std::size_t>& parts);

}  // namespace detail
}  // namespace palpa
