// palpa-fetch as a child process: files of a store that a server gives by HTTP.
#pragma once

#include <filesystem>
#include <memory>

#include "palpa/file/read_volume.h"
#include "palpa/file/reader_process.h"

namespace palpa::detail {

/// Starts palpa-fetch, which lies beside palpa-read, for a store at a web address, and sends it the address. Of any other place
/// null: no program with a network is started for it. The reader gets the socket with its request, and sends FetchRequests.
/// Throws LoadError with a sentence: the address is wrong, the program is missing.
std::unique_ptr<ReaderProcess> start_fetch(const std::filesystem::path& store, const ReadOptions& options);

/// [s] Without progress a reader of this place is ended: of a web address longer than palpa-fetch takes to give up a file.
double idle_limit_s(const std::filesystem::path& store, const ReadOptions& options) noexcept;

/// Throws LoadError "ADDRESS: …" of a web address, where `what` is done to files: "palpa prepare".
void refuse_web_address(const std::filesystem::path& place, const std::string& what);

}  // namespace palpa::detail
