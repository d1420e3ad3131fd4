// What palpa-read and the programs that it becomes have in common: a caller at the other end of a socket, to whom failures are
// sent in one line.
#pragma once

#include <functional>

#include "palpa/file/protocol.h"

namespace palpa::reader {

/// Runs `work` with the caller's socket and ends the process with 0, or with 1 after sending the caller what `work` threw.
/// Without a caller: prints a hint and returns 2.
int run_program(const std::function<void(int socket)>& work);

/// The caller's request. Throws LoadError.
/// \param take      false: it stays for the program that this one becomes
/// \param unpacked  a file of memory for what the file holds, where it is packed as a whole; -1: none came
protocol::Request receive_request(int socket, bool take, int* unpacked = nullptr);

}  // namespace palpa::reader
