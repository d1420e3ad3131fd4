// Frame of palpa-read and its format programs: a caller at the other end of a socket, and failures sent in one line.
#pragma once

#include <functional>

#include "palpa/file/protocol.h"

namespace palpa::reader {

/// Runs `work` with the caller's socket and ends the process with 0, or with 1 after sending an exception of `work`. Without a
/// caller: prints a hint and returns 2.
int run_program(const std::function<void(int socket)>& work);

/// Request of the caller. Throws LoadError.
/// \param take      false: leaves it in the socket for the format program
/// \param unpacked  memory file for the decompressed file; -1: none
protocol::Request receive_request(int socket, bool take, int* unpacked = nullptr);

}  // namespace palpa::reader
