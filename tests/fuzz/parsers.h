// The parsers that are ours, each with what it promises of any bytes. Campaigns give them damaged seeds, libFuzzer what it
// finds (libfuzzer.cpp).
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
  /// The promise that was broken, in one line; empty: all was kept. Whatever it writes it writes into the folder, which is
  /// there.
  std::string (*broken_by)(std::string_view bytes, const fs::path& folder);
  /// What it takes, to begin with.
  std::vector<std::string> (*seeds)();
};

/// The packets of palpa-read's protocol, the TOML guard, the CSV of traces, recorded hands, traces.
std::vector<Parser> parsers();
/// The headers of NRRD and MetaImage, as palpa-read opens them. Only where that is built.
std::vector<Parser> parsers_of_reader();

/// What every error of ours promises: one line, in words, `PLACE: what is wrong; what would be right`. Empty, or what was
/// broken.
std::string broken_by_refusal(std::string_view text);

/// A message as its bytes.
std::string bytes_of(const protocol::Message& message);
/// A packet is a message or none; a message is packed again to the same bytes, and its voxels have a size.
std::string broken_by_packet(std::string_view bytes, const fs::path& folder);

}  // namespace palpa::fuzz
