// Main program of readers that parse files: takes a request, sends the file's header, then its voxels.
#pragma once

#include <initializer_list>
#include <memory>
#include <string_view>

#include "source.h"

namespace palpa::reader {

using Open = std::unique_ptr<Source> (*)(const protocol::Request& request);

struct Format {
  std::string_view name;  ///< format's name in palpa-read
  Open open;
};

/// Allows memory for further files of `bytes`, which the request's file names and whose content is read with its header.
void allow_memory(const protocol::Request& request, std::uint64_t bytes);

/// Allows memory for further `bytes`.
void allow_memory(std::uint64_t bytes);

/// Answers one request for a file of the format that palpa-read has named; returns the exit code.
int serve(const char* format, std::initializer_list<Format> formats);

}  // namespace palpa::reader
