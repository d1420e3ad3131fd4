// NRRD and MetaImage as palpa-read opens them, without its process limits and sandbox.
#include <algorithm>
#include <fstream>
#include <memory>
#include <new>

#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "reader/source.h"
#include "tests/fuzz/parsers.h"

namespace palpa::reader {
std::unique_ptr<Source> open_nrrd(const protocol::Request& request);
std::unique_ptr<Source> open_metaimage(const protocol::Request& request);
}  // namespace palpa::reader

namespace palpa::fuzz {
namespace {

using Open = std::unique_ptr<reader::Source> (*)(const protocol::Request&);

/// A header is refused, or it fits a packet and its voxels are read into the requested memory.
std::string broken_by(Open open, const char* name, std::string_view bytes, const fs::path& folder) {
  const fs::path file = folder / name;
  std::ofstream(file, std::ios::binary) << bytes;
  protocol::Request request;
  request.path = file.string();
  request.frame = VolumeRequest::all_frames;
  try {
    const std::unique_ptr<reader::Source> source = open(request);
    if (protocol::packed(source->header).size() > protocol::max_packet_bytes) return "a header fits a packet";
    protocol::ReadRequest room;
    for (std::uint32_t n = 0; n < source->header.fields.size(); ++n) room.fields.push_back(n);
    room.frames = static_cast<std::int32_t>(source->frames_read);
    const auto places = protocol::place(source->header, room);
    constexpr std::uint64_t most_bytes = 1 << 22;
    if (!places || places->back() > most_bytes || source->header.working_bytes > most_bytes) return {};  // as a caller would
    std::vector<std::vector<std::byte>> memory;  // separate, so that an overrun of either is found
    std::vector<std::byte*> to;
    for (std::size_t n = 0; n < room.fields.size() * static_cast<std::size_t>(room.frames); ++n) {
      memory.emplace_back(*protocol::voxel_bytes(source->header.fields[n % room.fields.size()]));
      to.push_back(memory.back().data());
    }
    source->put = [](std::byte* at, const std::byte* from, std::uint64_t count) { std::copy_n(from, count, at); };
    source->read(room.fields, to);
    source->check_files();
  } catch (const LoadError& error) {
    return broken_by_refusal(detail::sanitized(error.what()));  // as its caller shows it
  } catch (const std::bad_alloc&) {                             // palpa-read has a message for it
  }
  return {};
}

std::string broken_by_nrrd(std::string_view bytes, const fs::path& folder) {
  return broken_by(reader::open_nrrd, "a.nrrd", bytes, folder);
}
std::string broken_by_metaimage(std::string_view bytes, const fs::path& folder) {
  return broken_by(reader::open_metaimage, "a.mha", bytes, folder);
}

std::vector<std::string> seeds_of_nrrd() {
  return {
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 3 2\nspace: left-posterior-superior\n"
      "space directions: (1,0,0) (0,1,0.5) (0,0,2)\nspace origin: (1,2,3)\nkinds: domain domain domain\nendian: little\n"
      "encoding: raw\nspace units: \"mm\" \"mm\" \"mm\"\n\n" +
          std::string(24, 'v'),
      "NRRD0005\ntype: float\ndimension: 4\nsizes: 3 2 2 2\nspace: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
      "measurement frame: (1,0,0) (0,1,0) (0,0,1)\nkinds: vector domain domain domain\nencoding: ascii\n\n" +
          [] {
            std::string numbers;
            for (int n = 0; n < 24; ++n) numbers += std::to_string(n) + " ";
            return numbers;
          }(),
      "NRRD0001\ntype: uchar\ndimension: 4\nsizes: 2 2 2 3\nspacings: 1 1 1 nan\nencoding: raw\nkey:=value\n\n" +
          std::string(24, 'v'),
      "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: hex\ndata file: a.raw\n"};
}

std::vector<std::string> seeds_of_metaimage() {
  return {
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nAnatomicalOrientation = RAI\nElementSpacing = 1 1 2\n"
      "DimSize = 2 3 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" +
          std::string(24, 'v'),
      "NDims = 4\nDimSize = 2 2 2 2\nElementNumberOfChannels = 3\nElementType = MET_UCHAR_ARRAY\nElementDataFile = LOCAL\n" +
          std::string(48, 'v'),
      "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LIST\na.raw\nb.raw\n"};
}

}  // namespace

std::vector<Parser> parsers_of_reader() {
  return {{"nrrd", broken_by_nrrd, seeds_of_nrrd}, {"metaimage", broken_by_metaimage, seeds_of_metaimage}};
}

}  // namespace palpa::fuzz
