// Palpa's parsers, each with its promise for any bytes, for campaigns and libFuzzer (libfuzzer.cpp).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/file/protocol.h"

namespace palpa::fuzz {

namespace fs = std::filesystem;

struct Parser {
  std::string name;
  /// The broken promise, in one line; empty: none. Writes only into the folder, which exists.
  std::string (*broken_by)(std::string_view bytes, const fs::path& folder);
  /// Valid inputs.
  std::vector<std::string> (*seeds)();
};

/// The packets of palpa-read's protocol, the TOML guard, the CSV of traces, recorded hands, traces.
std::vector<Parser> parsers();
/// The headers of NRRD and MetaImage, as palpa-read opens them, if it is built.
std::vector<Parser> parsers_of_reader();

/// Promise of every error message: one line, in words, `PLACE: what is wrong; what would be right`. Empty, or the broken
/// promise.
std::string broken_by_refusal(std::string_view text);

std::string bytes_of(const protocol::Message& message);
/// A packet is a message or none; a message packs to equal bytes, and its voxels have a size.
std::string broken_by_packet(std::string_view bytes, const fs::path& folder);

}  // namespace palpa::fuzz
