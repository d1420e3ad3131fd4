// Rows of slices on request (palpa/file/store_protocol.h), for volumes larger than memory.
#pragma once

#include "source.h"

namespace palpa::reader {

/// Answers requests for rows until the caller leaves, after the header has been sent. Throws LoadError with a sentence.
void serve_rows(int socket, Source& source);

}  // namespace palpa::reader
