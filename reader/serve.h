// What every program does that parses files: takes a request, answers with the header of the file, then with the voxels.
#pragma once

#include <initializer_list>
#include <memory>
#include <string_view>

#include "source.h"

namespace palpa::reader {

using Open = std::unique_ptr<Source> (*)(const protocol::Request& request);

struct Format {
  std::string_view name;  ///< as palpa-read names it
  Open open;
};

/// The whole of such a program: answers one request for a file of the format that palpa-read has named.
int serve(const char* format, std::initializer_list<Format> formats);

}  // namespace palpa::reader
