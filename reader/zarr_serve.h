// Service of a store's chunks to StoreReader.
#pragma once

#include "zarr_store.h"

namespace palpa::reader {

/// Sends the content of a store, then reads the requested chunks into the caller's memory until the caller closes the socket.
/// Several chunks are read at once. Ends the process where one takes too much computing. Throws LoadError with a sentence.
void serve_store(int socket, const ZarrStore& store);

}  // namespace palpa::reader
