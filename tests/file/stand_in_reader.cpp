// Stand-in for palpa-read, right or faulty by $STAND_IN.
#include <pthread.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "palpa/file/protocol.h"
#include "palpa/file/protocol_memory.h"
#include "palpa/file/store_protocol.h"

namespace {

/// Store of 2 × 2 × 2 chunks, whose voxels have the number of their request.
int serve_store(const std::string& part, int socket) {
  using namespace palpa;
  using namespace palpa::protocol;
  StoreContents contents;
  contents.format = "stand-in";
  contents.fields = {{.name = "value", .file_type = "uint8"}};
  contents.octaves = {{.chunk = {4, 4, 4}, .shard = {4, 4, 4}, .codec = "raw"}};
  contents.octaves[0].grid.dims = {8, 8, 8};
  if (part == "huge store") contents.octaves[0].grid.dims[0] = INT64_MAX;
  if (part == "no field of a store") contents.fields.clear();
  send(socket, contents);
  bool garbled = false;
  const auto room = receive(socket, garbled);
  if (!room || !std::holds_alternative<StoreRoom>(room->message)) return 1;
  const auto& slots = std::get<StoreRoom>(room->message);
  const std::uint64_t bytes = slots.slot_bytes * static_cast<std::uint64_t>(slots.slots);
  const Memory memory = mapped({room->descriptor, room->second_descriptor}, bytes, true);
  if (part == "shrink" && ::ftruncate(room->descriptor, 1) == 0) return 3;
  if (part == "unasked chunk") send(socket, ChunkAnswer{{}, 0});
  for (unsigned char n = 1;; ++n) {
    const auto asked = receive(socket, garbled);
    if (!asked || !std::holds_alternative<ChunkRequest>(asked->message)) return 0;
    const auto request = std::get<ChunkRequest>(asked->message);
    ChunkAnswer answer{request.chunk, request.slot, ChunkState::present, 64};
    std::memset(memory.all.get() + static_cast<std::uint64_t>(request.slot) * slots.slot_bytes, n, 64);
    if (part == "another slot") answer.slot = 1;
    if (part == "slot beyond") answer.slot = 1'000'000;
    if (part == "another chunk") answer.chunk.at[0] = 1;
    if (part == "two answers") send(socket, answer);
    if (part == "hang with a chunk") ::pause();
    if (part == "spin with a chunk")
      for (volatile bool goes_on = true; goes_on;) continue;
    if (part == "killed with a chunk") std::raise(SIGKILL);
    if (part == "words") answer.state = ChunkState::damaged, answer.sentence = "a\nb\x9b[31m" + std::string(4000, 'x');
    if (part == "refuse a chunk") send(socket, Failure{"has enough; ask no more"});
    send(socket, answer);
  }
}

}  // namespace

int main() {
  using namespace palpa;
  using namespace palpa::protocol;
  const char* variable = std::getenv("STAND_IN");
  const std::string part = variable != nullptr ? variable : "";
  const int socket = socket_descriptor;
  bool garbled = false;

  if (part == "exit at once") return 7;
  if (part == "abort at once") std::abort();
  if (part == "forbidden") std::raise(SIGSYS);
  if (part == "hang at once") ::pause();
  if (part == "too many threads") {
    pthread_attr_t small;
    ::pthread_attr_init(&small);
    ::pthread_attr_setstacksize(&small, 1 << 16);
    pthread_t thread{};
    for (int made = 0; made < 3000; ++made)  // bounded, so that the test is harmless
      ::pthread_create(&thread, &small, [](void*) -> void* { return ::pause(), nullptr; }, nullptr);
    ::pause();
  }
  auto request = receive(socket, garbled);
  if (!request) return 1;
  if (part == "nonsense") {
    ::send(socket, "the quick brown fox jumps over the lazy dog", 43, 0);
    ::pause();
  }
  if (part == "wrong turn") {
    send(socket, Done{});
    ::pause();
  }
  if (part == "close and stay") {
    ::close(socket);
    ::pause();
  }
  if (part == "failure") {
    send(socket, Failure{"is not liked; bring another"});
    return 1;
  }
  if (part == "no sentence") {
    send(socket, Failure{"\xff\x9b[31m \u202e\u0085 is not liked"});
    return 1;
  }
  if (part == "long sentence") {
    send(socket, Failure{"is not liked; " + std::string(4000, 'x')});
    return 1;
  }

  if (const auto* asked = std::get_if<Request>(&request->message); asked != nullptr && asked->store)
    return serve_store(part, socket);

  Header header;
  header.format = "nrrd", header.default_unit = "mm";
  FieldHeader field;
  field.name = "value", field.type = VoxelType::uint8;
  field.grid.dims = {4, 4, 4};
  if (part == "no fields") {
    send(socket, header);
    ::pause();
  }
  if (part == "too large") field.grid.dims = {1'000'000, 1'000'000, 1'000'000};
  if (part == "much too large") field.grid.dims = {INT64_MAX, INT64_MAX, 2};
  if (part == "flat") field.grid.index_to_world_m.row[2] = {};
  if (part == "no number") field.grid.origin_m.x = std::strtod("nan", nullptr);
  if (part == "no scale") field.scale = 0;
  if (part == "hungry") header.working_bytes = UINT64_MAX;
  header.fields = {field};
  send(socket, header);

  auto room = receive(socket, garbled);
  if (!room || room->descriptor < 0) return 1;
  if (part == "killed in the middle") std::raise(SIGKILL);
  if (part == "segfault in the middle") {
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers take it
    std::raise(SIGSEGV);
  }
  if (part == "exit in the middle") return 0;
  if (part == "hang in the middle") ::pause();
  if (part == "spin in the middle") {
    volatile bool go_on = true;
    while (go_on) {
    }
  }
  if (part == "shrink" && ::ftruncate(room->descriptor, 1) == 0) return 3;  // must not be possible
  if (part == "header again") {
    send(socket, header);
    ::pause();
  }
  void* memory = ::mmap(nullptr, 64, PROT_READ | PROT_WRITE, MAP_SHARED, room->descriptor, 0);
  if (memory == MAP_FAILED) return 4;
  for (int v = 0; v < 64; ++v) static_cast<unsigned char*>(memory)[v] = static_cast<unsigned char>(v);
  if (part.starts_with("later")) ::munmap(memory, 64);
  send(socket, Done{{{"a file", 1, "00"}}, {"a late warning"}});
  if (part == "later") send(socket, Done{{{"a file", 1, "00ff"}}, {}});
  if (part == "stay" || part == "later hangs") ::pause();
  return 0;
}
