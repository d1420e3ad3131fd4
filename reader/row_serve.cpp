#include "row_serve.h"

#include <algorithm>

#include "palpa/file/protocol_memory.h"
#include "palpa/file/store_protocol.h"
#include "serve.h"

namespace palpa::reader {

void serve_rows(int socket, Source& source) {
  const StoreContents contents = protocol::contents_by_rows(source.header);
  if (contents.octaves.empty()) return;
  bool garbled = false;
  const auto first = protocol::receive(socket, garbled);
  if (!first || !std::holds_alternative<protocol::StoreRoom>(first->message) || first->descriptor < 0) return;
  const auto room = std::get<protocol::StoreRoom>(first->message);
  if (room.slots < 1 || room.slots > protocol::most_slots || room.slot_bytes != protocol::slot_bytes(contents)) return;
  const std::uint64_t bytes = room.slot_bytes * static_cast<std::uint64_t>(room.slots);
  allow_memory(bytes + source.header.working_bytes + 2 * room.slot_bytes);
  const protocol::Memory memory = protocol::mapped({first->descriptor, first->second_descriptor}, bytes, true);
  const StoreOctave& octave = contents.octaves.front();
  while (const auto message = protocol::receive(socket, garbled)) {
    const auto* const request = std::get_if<protocol::ChunkRequest>(&message->message);
    if (request == nullptr || request->slot < 0 || request->slot >= room.slots ||
        !protocol::has_place(contents, request->chunk))
      return;
    const std::int64_t from = request->chunk.at[1] * octave.chunk[1];
    const std::int64_t count = std::min(octave.chunk[1], octave.grid.dims[1] - from);
    source.read_rows(static_cast<std::uint32_t>(request->chunk.field), request->chunk.at[2], from, count,
                     memory.all.get() + static_cast<std::uint64_t>(request->slot) * room.slot_bytes);
    const protocol::ChunkAnswer answer{request->chunk, request->slot, ChunkState::present,
                                       protocol::content_bytes(contents, request->chunk)};
    if (!protocol::send(socket, answer)) return;
  }
}

}  // namespace palpa::reader
