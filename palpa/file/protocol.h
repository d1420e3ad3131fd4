// What a program that opens a volume and the child that parses its file, palpa-read, say to each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "palpa/grid/grid.h"
#include "palpa/volume/volume.h"

/// The conversation, over one SOCK_SEQPACKET pair, one message per packet:
///
///     caller                              palpa-read
///     Request (path, what of it;     ──►
///      memory, if it is packed)
///                                    ◄──  Header (grids, fields, bytes)      or Failure
///     Room (fields wanted, + memory) ──►    (protocol_memory.h)
///                                    ◄──  Done (files and their checksums; several, where they
///                                         are too many for a packet)         or Failure
///
/// Both ends check every message: a child that parses a damaged file is not to be trusted, and a child
/// started by hand has no caller. Numbers are in the byte order of the machine.
namespace palpa::protocol {

inline constexpr std::uint16_t version = 5;               ///< differs: the two programs do not belong together
inline constexpr std::size_t max_packet_bytes = 1 << 17;  ///< a longer message throws; each receive takes so much memory
inline constexpr int socket_descriptor = 3;               ///< where palpa-read finds its end of the pair

struct Request {
  std::string path;
  std::string as;                       ///< "vector": a file of three frames is one vector; else empty
  std::int32_t frame = -1;              ///< of a file with several; -1: the first, with a warning; VolumeRequest::all_frames
  std::uint64_t max_bytes = 0;          ///< voxels that would need more are refused
  std::string series{};                 ///< of a DICOM folder with several; empty: the largest, with a warning
  std::string components_along{};       ///< "index": vectors are along the axes of the grid; else as the format says
  std::vector<std::string> partners{};  ///< further files that belong to it
  std::string inside{};                 ///< which array of an HDF5 file: "/velocity"; empty: the file says it
  ArrayLayout layout{};                 ///< of that array, lengths in the file's unit
  std::optional<double> time_s{};       ///< [s] of a case with several moments; none: the latest
  std::optional<Box> crop{};            ///< in the file's unit of length: the part to resample
  bool checksums = true;                ///< those of the files are wanted

  /// Not sent: the file that `path` was unpacked from by the reader; empty: none.
  std::string packed{};
  int memory = -1;  ///< Not sent: a file of memory that came along, for files of a folder that have to be unpacked; -1: none
};

/// One array of voxels as palpa-read will hand it over: i fastest, components of one voxel together,
/// vectors already along the axes of the world.
struct FieldHeader {
  std::string name;
  std::string unit;  ///< of the values, as the file says it
  VoxelType type = VoxelType::float32;
  std::int32_t components = 1;
  GridGeometry grid;    ///< in the file's unit of length, not in metres; of planes only whether there are any
  double scale = 1.0;   ///< the field's own unit, per raw step: value = raw · scale + offset
  double offset = 0.0;  ///< the field's own unit
};

struct Header {
  std::string format;              ///< as in `Volume::format`
  std::string modality;            ///< as in `Volume::modality`
  std::vector<ScanFact> scan;      ///< as in `Volume::scan`
  std::string frame_of_reference;  ///< as in `Volume::frame_of_reference`
  std::string length_unit;         ///< as the file says it; empty if it does not
  std::string default_unit;        ///< of the format
  bool medical_frame = false;      ///< the grids are in LPS
  bool named = false;              ///< the file itself names its arrays
  std::int32_t frames = 1;
  std::uint64_t working_bytes = 0;  ///< what reading takes beside the voxels
  std::vector<FieldHeader> fields;
  std::vector<std::string> warnings;
};

/// Comes with one or two file descriptors: memory for the wanted fields, one after the other as `place` says.
struct Room {
  std::vector<std::uint32_t> fields;  ///< indices into Header::fields, rising
  std::int32_t frames = 1;            ///< that are wanted of each: one, or all that the header says
};

struct Done {
  std::vector<SourceFile> files;
  std::vector<std::string> warnings;
  std::vector<Resampling> resampled{};  ///< one for each wanted field, or none at all
  bool more = false;                    ///< another one follows, with further files
};

struct Failure {
  std::string sentence;  ///< "what is wrong; what would be right", without the file's name
};

using Message = std::variant<Request, Header, Room, Done, Failure>;

/// Bytes of one field's voxels; nullopt where dims, components or the product are not sensible.
std::optional<std::uint64_t> voxel_bytes(const FieldHeader& field) noexcept;

/// Doubles that follow a field's voxels, at the next multiple of 8 bytes: the planes of a rectilinear grid, along i, j, k.
std::uint64_t plane_numbers(const FieldHeader& field) noexcept;

/// Offsets of the wanted fields in the shared memory, those of the second frame behind those of the first, and so on; and as
/// the last one the size of all of it. nullopt where an index is wrong, there is no such number of frames, or the sum
/// overflows.
std::optional<std::vector<std::uint64_t>> place(const Header& header, const Room& room);

/// The message as one packet.
std::vector<std::byte> packed(const Message& message);
/// The message in a packet; nullopt where it is none of this version.
std::optional<Message> unpacked(const std::byte* bytes, std::size_t size);

/// Sends one message, with a descriptor or two, if >= 0. Never raises SIGPIPE. False: the other end is gone.
bool send(int socket, const Message& message, int descriptor = -1, int second_descriptor = -1);

struct Received {
  Message message;
  int descriptor = -1;         ///< owned by whoever receives; -1: none came
  int second_descriptor = -1;  ///< the same
};
/// Waits for one message. nullopt: the other end is gone, or what came was no message (`garbled`).
/// \param take  false: the message stays for whoever receives next; descriptors come anew each time
std::optional<Received> receive(int socket, bool& garbled, bool take = true);

/// "3.2 GB": decimal units, two significant digits or more.
std::string readable_bytes(double bytes);

}  // namespace palpa::protocol
