// How the reading of a file is written into a scene: the keys of [volume.NAME] for a request.
#pragma once

#include <string>

#include "palpa/volume/volume.h"

namespace palpa::detail {

/// `file = …`, with whole paths, so that it holds in any folder; a list where several files make one volume.
std::string file_line(const VolumeRequest& request);

/// `NAME = {array = …, unit = …}`, without what goes without saying.
std::string field_entry(const VolumeRequest::FieldRequest& field);

/// The keys whose reasons are the user's alone: all but `file`, `length_unit`, `fields`, `frame` and `as`.
std::string asked_for(const VolumeRequest& request);

/// All keys of a request. Allocates.
std::string reading_of(const VolumeRequest& request);

}  // namespace palpa::detail
