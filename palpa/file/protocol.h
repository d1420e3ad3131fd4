// Protocol between a program that opens a volume and palpa-read, the child process that parses its file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/file/store_contents.h"

/// Sequence over one SOCK_SEQPACKET pair, one message per packet:
///
///     caller                              palpa-read
///     Request (path, what of it;     ──►
///      memory, if it is packed)
///                                    ◄──  Header (grids, fields, bytes)      or Failure
///     ReadRequest (fields wanted, + memory) ──►    (protocol_memory.h)
///                                    ◄──  Done (files and their checksums; several, where they
///                                         are too many for a packet)         or Failure
///
/// A store (`Request::store`) is answered by its StoreContents instead of a Header; store_protocol.h has the sequence.
///
/// Both ends check every message: a child that parses a damaged file is untrusted, and a child started by hand has no caller.
/// Numbers are in the byte order of the machine.
namespace palpa::protocol {

inline constexpr std::uint16_t version = 9;               ///< differs: incompatible programs
inline constexpr std::size_t max_packet_bytes = 1 << 17;  ///< a longer message throws; each receive allocates this
inline constexpr int socket_descriptor = 3;               ///< palpa-read's end of the pair

struct Request {
  std::string path;
  std::string as;                        ///< "vector": a file of three frames is one vector; else empty
  std::int32_t frame = -1;               ///< of a file with several; -1: the first, with a warning; VolumeRequest::all_frames
  std::uint64_t max_bytes = 0;           ///< voxels beyond this are refused
  std::string series{};                  ///< of a DICOM folder with several; empty: the largest, with a warning
  std::string components_along{};        ///< "index": vectors are along the axes of the grid; else by the format
  std::vector<std::string> partners{};   ///< further files of the volume
  std::string inside{};                  ///< array of an HDF5 file: "/velocity"; empty: the file's own choice
  ArrayLayout layout{};                  ///< of that array, lengths in the file's unit
  std::optional<double> time_s{};        ///< [s] of a case with several moments; none: the latest
  std::optional<Box> crop{};             ///< in the file's unit of length: region to resample
  Checksums checksums = Checksums::now;  ///< later: a second series of Done follows, with them
  bool listing = false;                  ///< a file of which one array has to be named is answered by a header without fields
  bool store = false;                    ///< chunks are requested one by one (store_protocol.h); only of an OME-Zarr store
  bool rows = false;                     ///< rows of slices are requested one by one, if the header permits (`reads_rows`)

  /// Not sent: source file of `path`, unpacked by the reader; empty: none.
  std::string packed{};
  int memory = -1;  ///< Not sent: a file of memory that came along, for files of a folder that have to be unpacked; -1: none
};

/// Array of voxels as palpa-read delivers it: i fastest, components of a voxel together, vectors along the axes of the world.
struct FieldHeader {
  std::string name;
  std::string unit;  ///< of the values, from the file
  VoxelType type = VoxelType::float32;
  std::int32_t components = 1;
  GridGeometry grid;    ///< in the file's unit of length, not in metres; planes: only their presence
  double scale = 1.0;   ///< the field's own unit, per raw step: value = raw · scale + offset
  double offset = 0.0;  ///< the field's own unit
};

struct Header {
  std::string format;              ///< as in `Volume::format`
  std::string modality;            ///< as in `Volume::modality`
  std::vector<ScanFact> scan;      ///< as in `Volume::scan`
  std::string frame_of_reference;  ///< as in `Volume::frame_of_reference`
  std::string length_unit;         ///< from the file; empty if unknown
  std::string default_unit;        ///< of the format
  bool medical_frame = false;      ///< the grids are in LPS
  bool named = false;              ///< the file names its arrays
  std::int32_t frames = 1;
  std::uint64_t working_bytes = 0;  ///< memory for reading beside the voxels
  bool reads_rows = false;          ///< rows of slices can be read alone (store_protocol.h)
  std::vector<FieldHeader> fields;
  std::vector<std::string> warnings;
  std::vector<FilePart> series{}, labels{}, alternatives{};  ///< as in `FileContents`; cut where a packet holds no more
};

/// Sent with one or two file descriptors: memory for the requested fields, in the layout of `place`.
struct ReadRequest {
  std::vector<std::uint32_t> fields;  ///< indices into Header::fields, rising
  std::int32_t frames = 1;            ///< requested of each: one, or all of the header
};

struct Done {
  std::vector<SourceFile> files;
  std::vector<std::string> warnings;
  std::vector<Resampling> resampled{};  ///< one for each requested field, or none
  bool more = false;                    ///< another Done follows, with further files
};

struct Failure {
  std::string sentence;  ///< "fault; remedy", without the file's name
};

/// Memory for chunks of a store, sent with one or two file descriptors: `slots` pieces of `slot_bytes`.
struct StoreRoom {
  std::int32_t slots = 1;
  std::uint64_t slot_bytes = 0;
};

/// Request for a chunk of a store.
struct ChunkRequest {
  StoreChunk chunk;
  std::int32_t slot = 0;  ///< of the room, with no request pending
};

/// Chunk that was read, or found absent or damaged.
struct ChunkAnswer {
  StoreChunk chunk;
  std::int32_t slot = 0;
  ChunkState state = ChunkState::present;
  std::uint64_t bytes = 0;  ///< read from the store
  std::string sentence{};   ///< of a damaged chunk
};

/// Request of palpa-read-zarr to palpa-fetch for a file of a store, or a part of it (store_protocol.h).
struct FetchRequest {
  std::uint32_t number = 0;      ///< of the request, for its answer
  std::string name{};            ///< path in the store: "0/1/2/3"
  std::uint64_t first = 0;       ///< [bytes] begin of the part; with `from_end` its length
  std::uint64_t bytes = 0;       ///< [bytes] of the part; 0: the whole file
  bool from_end = false;         ///< the last `bytes` of the file
  std::uint64_t most_bytes = 0;  ///< a file that is longer is refused, where it comes as a whole
};

enum class FetchState : std::uint8_t { present, absent, failed };

/// Answer, with a descriptor of a file in memory that holds the bytes where they are present.
struct FetchAnswer {
  std::uint32_t number = 0;
  FetchState state = FetchState::failed;
  std::uint64_t first = 0;        ///< [bytes] place of the content in the file
  std::uint64_t whole_bytes = 0;  ///< [bytes] of the file
  bool is_forbidden = false;      ///< failed, as the server permits it to none
  std::string sentence{};         ///< of a failure
};

using Message = std::variant<Request, Header, ReadRequest, Done, Failure, StoreContents, StoreRoom, ChunkRequest, ChunkAnswer,
                             FetchRequest, FetchAnswer>;

/// Bytes of a field's voxels; nullopt if dims, components or the product are invalid.
std::optional<std::uint64_t> voxel_bytes(const FieldHeader& field) noexcept;

/// Doubles after a field's voxels, at the next multiple of 8 bytes: the planes of a rectilinear grid, along i, j, k.
std::uint64_t plane_numbers(const FieldHeader& field) noexcept;

/// Frame-major offsets of the requested fields in the shared memory; the last element is the total size. nullopt on a wrong
/// index or number of frames, or on overflow.
std::optional<std::vector<std::uint64_t>> place(const Header& header, const ReadRequest& room);

/// Message as a packet.
std::vector<std::byte> packed(const Message& message);
/// Message of a packet; nullopt if invalid in this version.
std::optional<Message> unpacked(const std::byte* bytes, std::size_t size);

/// Sends a message, with up to two descriptors >= 0. Never raises SIGPIPE. False: the other end is closed.
bool send(int socket, const Message& message, int descriptor = -1, int second_descriptor = -1);

struct Received {
  Message message;
  int descriptor = -1;         ///< owned by the receiver; -1: none
  int second_descriptor = -1;  ///< likewise
};
/// Blocks for a message. nullopt: the other end is closed, or the packet is invalid (`garbled`).
/// \param take  false: the message stays in the queue; descriptors are duplicated each time
std::optional<Received> receive(int socket, bool& garbled, bool take = true);

/// "3.2 GB": decimal units, two significant digits or more.
std::string readable_bytes(double bytes);

}  // namespace palpa::protocol
