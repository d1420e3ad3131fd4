#include "zarr_serve.h"

#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <ctime>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "palpa/file/protocol_memory.h"
#include "palpa/file/store_protocol.h"
#include "serve.h"

namespace palpa::reader {
namespace {

/// Chunks read at once, which the disk blocks most of the time. More: more memory; fewer: slow networks are used less.
constexpr std::uint64_t most_workers = 8, most_scratch_bytes = 256'000'000;
/// Likewise of chunks that are fetched, each in a round trip of 10 to 200 ms, in which a worker takes no processor.
constexpr std::uint64_t most_fetching_workers = 64;
constexpr std::uint64_t stack_bytes = std::uint64_t{8} << 20;
/// Computing for one chunk. More: a hostile one holds a worker for longer; less: large ones are refused on slow machines.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::int64_t most_cpu_ns = 20'000'000'000;
#else
constexpr std::int64_t most_cpu_ns = 1'000'000'000;
#endif
constexpr int look_every_ms = 100;

[[noreturn]] void end_with(int socket, const std::string& sentence) {
  protocol::send(socket, protocol::Failure{sentence});
  ::_exit(1);
}

std::int64_t cpu_ns(clockid_t clock) {
  timespec time{};
  return ::clock_gettime(clock, &time) == 0 ? std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec : 0;
}

/// Requests, and the threads that work them off until the process ends.
class Workers {
 public:
  Workers(int socket, const ZarrStore& store, const protocol::StoreRoom& room, std::byte* memory)
      : socket_(socket), store_(store), room_(room), memory_(memory) {
    const std::uint64_t fitting = most_scratch_bytes / std::max<std::uint64_t>(store.scratch_bytes(), 1);
    count_ =
        std::clamp<std::uint64_t>(std::min<std::uint64_t>(fitting, static_cast<std::uint64_t>(room.slots)), 1, most_of(store));
    for (std::uint64_t n = 0; n < count_; ++n) {
      std::thread thread([this, n] { work(busy_[n]); });
      ::pthread_getcpuclockid(thread.native_handle(), &busy_[n].clock);
      thread.detach();
    }
  }

  static std::uint64_t most_of(const ZarrStore& store) { return store.is_fetched() ? most_fetching_workers : most_workers; }

  void add(const protocol::ChunkRequest& request) {
    {
      const std::scoped_lock lock(mutex_);
      waiting_.push_back(request);
    }
    ++unfinished_;
    changed_.notify_one();
  }
  bool has_work() const { return unfinished_ > 0; }

  /// Ends the process where a chunk has taken too much computing.
  void watch() const {
    for (std::uint64_t n = 0; n < count_; ++n) {
      const Busy& busy = busy_[n];
      const std::int64_t begin_ns = busy.begin_ns;
      if (begin_ns < 0 || cpu_ns(busy.clock) - begin_ns < most_cpu_ns || busy.begin_ns != begin_ns) continue;
      end_with(socket_, "has a chunk that took more than a second of computing; the store is probably damaged");
    }
  }

 private:
  struct Busy {
    std::atomic<std::int64_t> begin_ns = -1;  ///< CPU time of the thread at the begin of its chunk; -1: none
    clockid_t clock = 0;
  };

  void work(Busy& busy) {
    ZarrScratch scratch;
    while (true) {
      protocol::ChunkRequest request;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !waiting_.empty(); });
        request = waiting_.front();
        waiting_.pop_front();
      }
      busy.begin_ns = cpu_ns(CLOCK_THREAD_CPUTIME_ID);
      try {
        read(request, scratch);
      } catch (const std::exception&) {
        end_with(socket_, "has chunks that need more memory than is allowed; the store is probably damaged");
      }
      busy.begin_ns = -1;
      --unfinished_;
    }
  }

  void read(const protocol::ChunkRequest& request, ZarrScratch& scratch) const {
    std::byte* const slot = memory_ + static_cast<std::uint64_t>(request.slot) * room_.slot_bytes;
    const std::uint64_t bytes = protocol::content_bytes(store_.contents(), request.chunk);
    ZarrRead read = store_.read(request.chunk, {slot, static_cast<std::size_t>(bytes)}, scratch);
    if (!protocol::send(socket_,
                        protocol::ChunkAnswer{request.chunk, request.slot, read.state, read.bytes, std::move(read.sentence)}))
      ::_exit(0);  // the caller is gone
  }

  int socket_;
  const ZarrStore& store_;
  protocol::StoreRoom room_;
  std::byte* memory_;
  std::uint64_t count_ = 1;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<protocol::ChunkRequest> waiting_;
  std::atomic<std::int64_t> unfinished_ = 0;
  std::array<Busy, most_fetching_workers> busy_;
};

}  // namespace

void serve_store(int socket, const ZarrStore& store) {
  if (!protocol::send(socket, store.contents())) return;
  bool garbled = false;
  const auto first = protocol::receive(socket, garbled);
  if (!first || !std::holds_alternative<protocol::StoreRoom>(first->message) || first->descriptor < 0) return;
  const auto room = std::get<protocol::StoreRoom>(first->message);
  if (room.slots < 1 || room.slots > protocol::most_slots || room.slot_bytes != protocol::slot_bytes(store.contents())) return;
  const std::uint64_t bytes = room.slot_bytes * static_cast<std::uint64_t>(room.slots);
  const std::uint64_t stacks_and_indices_bytes = 256'000'000 + (store.is_fetched() ? most_fetching_workers * stack_bytes : 0);
  allow_memory(bytes + most_scratch_bytes + store.scratch_bytes() + stacks_and_indices_bytes);
  const protocol::Memory memory = protocol::mapped({first->descriptor, first->second_descriptor}, bytes, true);

  // Never destroyed: its threads end with the process.
  auto* const workers = new Workers(socket, store, room, memory.all.get());
  while (true) {
    pollfd ready{socket, POLLIN, 0};
    const int events = ::poll(&ready, 1, workers->has_work() ? look_every_ms : -1);
    workers->watch();
    if (events <= 0) continue;
    const auto message = protocol::receive(socket, garbled);
    const auto* request = message ? std::get_if<protocol::ChunkRequest>(&message->message) : nullptr;
    const bool is_valid = request != nullptr && request->slot >= 0 && request->slot < room.slots &&
                          protocol::has_place(store.contents(), request->chunk);
    if (!is_valid) ::_exit(0);
    workers->add(*request);
  }
}

}  // namespace palpa::reader
