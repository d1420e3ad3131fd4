#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpa/loop/loop.h"

namespace palpa {

namespace {

// Polling interval of the writing thread. Longer: a kill loses more ticks and the ring fills further; shorter: more wake-ups.
constexpr auto poll_interval = std::chrono::milliseconds(10);
// Ticks between flushes. More: a kill loses more; fewer: more system calls.
constexpr std::int64_t ticks_per_flush = 32;

/// Header of a tick in the ring, before its arrays.
struct TickHead {
  TickFrame frame;
  std::uint32_t modes;
  std::uint32_t sub_steps;
  std::uint32_t placed;
  std::uint32_t events;
  std::int64_t lost;  // ticks without room just before this one
};

static_assert(std::is_trivially_copyable_v<TickHead> && std::is_trivially_copyable_v<ModeForce> &&
              std::is_trivially_copyable_v<SubStep> && std::is_trivially_copyable_v<PlacedPrimitive> &&
              std::is_trivially_copyable_v<SessionEvent>);

/// A tick as read by the writing thread.
struct TakenTick {
  TickHead head;
  std::vector<ModeForce> modes;
  std::vector<SubStep> sub_steps;
  std::vector<PlacedPrimitive> placed;
  std::vector<SessionEvent> events;
};

}  // namespace

/// Ring of bytes with one producer, the loop, and one consumer, the writing thread. `begin_` and `end_` count bytes since the
/// start and only grow: the bytes between them are full; `begin_` is changed by the consumer alone, `end_` by the producer.
class Recorder::Ring {
 public:
  Ring(TraceWriter& writer, std::size_t bytes)
      : writer_(writer),
        bytes_(bytes),
        memory_(std::make_unique_for_overwrite<char[]>(bytes)),
        thread_([this] { write_until_finished(); }) {}
  ~Ring() { join(); }

  // ---- the loop's side ----

  void make_resident() noexcept { std::memset(memory_.get(), 0, bytes_); }

  bool offer(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
             std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) noexcept {
    if (!writer_.records_primitives()) {
      sub_steps = {};
      placed = {};
    }
    TickHead head{frame,
                  static_cast<std::uint32_t>(modes.size()),
                  static_cast<std::uint32_t>(sub_steps.size()),
                  static_cast<std::uint32_t>(placed.size()),
                  static_cast<std::uint32_t>(events.size()),
                  0};
    const std::size_t needed =
        sizeof head + modes.size_bytes() + sub_steps.size_bytes() + placed.size_bytes() + events.size_bytes();
    std::uint64_t end = end_.load(std::memory_order_relaxed);
    if (failed_.load(std::memory_order_relaxed) || end + needed - begin_.load(std::memory_order_acquire) > bytes_) {
      lost_ += frame.tick != refused_;
      refused_ = frame.tick;
      return false;
    }
    head.lost = std::exchange(lost_, 0) - (std::exchange(refused_, -1) == frame.tick);
    put(end, std::span<const TickHead>(&head, 1));
    put(end, modes);
    put(end, sub_steps);
    put(end, placed);
    put(end, events);
    end_.store(end, std::memory_order_release);
    taken_.fetch_add(1, std::memory_order_relaxed);
    return true;
  }

  void keep_up(std::int64_t most_pending_ticks) {
    std::unique_lock lock(mutex_);
    wanted_ = true;
    wake_writer_.notify_one();
    wake_loop_.wait(lock, [&] { return failure_ || taken_.load(std::memory_order_relaxed) - flushed_ <= most_pending_ticks; });
    if (failure_) std::rethrow_exception(failure_);
  }

  void finish() {
    join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void join() {
    if (!thread_.joinable()) return;
    {
      const std::lock_guard lock(mutex_);
      finishing_ = true;
    }
    wake_writer_.notify_one();
    thread_.join();
  }

  // Copies `values` behind `end`, wrapping round at the end of the memory.
  template <class T>
  void put(std::uint64_t& end, std::span<const T> values) noexcept {
    const char* from = reinterpret_cast<const char*>(values.data());
    const std::size_t size = values.size_bytes();
    if (size == 0) return;
    const std::size_t at = static_cast<std::size_t>(end % bytes_);
    const std::size_t first = std::min(size, bytes_ - at);
    std::memcpy(memory_.get() + at, from, first);
    std::memcpy(memory_.get(), from + first, size - first);
    end += size;
  }

  // ---- the writing thread's side ----

  template <class T>
  void get(std::uint64_t& begin, T* values, std::size_t count) noexcept {
    char* to = reinterpret_cast<char*>(values);
    const std::size_t size = count * sizeof(T);
    if (size == 0) return;
    const std::size_t at = static_cast<std::size_t>(begin % bytes_);
    const std::size_t first = std::min(size, bytes_ - at);
    std::memcpy(to, memory_.get() + at, first);
    std::memcpy(to + first, memory_.get(), size - first);
    begin += size;
  }
  template <class T>
  void get(std::uint64_t& begin, std::vector<T>& values, std::size_t count) {
    values.resize(count);
    get(begin, values.data(), count);
  }

  bool take(TakenTick& tick) {
    std::uint64_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    get(begin, &tick.head, 1);
    get(begin, tick.modes, tick.head.modes);
    get(begin, tick.sub_steps, tick.head.sub_steps);
    get(begin, tick.placed, tick.head.placed);
    get(begin, tick.events, tick.head.events);
    begin_.store(begin, std::memory_order_release);
    return true;
  }

  // Writes and flushes the ring's contents; publishes its progress after each flush.
  void drain(TakenTick& tick) {
    for (;;) {
      std::int64_t written = 0;
      while (written < ticks_per_flush && take(tick)) {
        if (tick.head.lost > 0) {
          const TickFrame& frame = tick.head.frame;
          writer_.append_event(frame.tick, frame.t_s, "lost_ticks", "recorder", std::to_string(tick.head.lost));
        }
        writer_.append(tick.head.frame, tick.modes, tick.sub_steps, tick.placed, tick.events);
        ++written;
      }
      if (written == 0) return;
      writer_.flush();
      {
        const std::lock_guard lock(mutex_);
        flushed_ += written;
      }
      wake_loop_.notify_one();
    }
  }

  void write_until_finished() {
    TakenTick tick;
    try {
      for (bool last = false; !last;) {
        {
          std::unique_lock lock(mutex_);
          wake_writer_.wait_for(lock, poll_interval, [&] { return wanted_ || finishing_; });
          wanted_ = false;
          last = finishing_;
        }
        drain(tick);
      }
    } catch (...) {
      failed_.store(true, std::memory_order_relaxed);
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      wake_loop_.notify_one();
    }
  }

  TraceWriter& writer_;
  std::size_t bytes_;
  std::unique_ptr<char[]> memory_;
  std::atomic<std::uint64_t> begin_{0};
  std::atomic<std::uint64_t> end_{0};
  std::atomic<std::int64_t> taken_{0};
  std::atomic<bool> failed_{false};
  std::int64_t lost_ = 0;      // the loop's: consecutive ticks without room
  std::int64_t refused_ = -1;  // the last of them: it may be offered again

  // Unused by the loop's `offer`.
  std::mutex mutex_;
  std::condition_variable wake_writer_, wake_loop_;
  bool wanted_ = false;
  bool finishing_ = false;
  std::int64_t flushed_ = 0;
  std::exception_ptr failure_;

  std::thread thread_;  // last: it uses all of the above
};

Recorder::Recorder(TraceWriter& writer, std::size_t ring_bytes) : ring_(std::make_unique<Ring>(writer, ring_bytes)) {}
Recorder::~Recorder() = default;

bool Recorder::offer(const TickFrame& frame, const Session& session) noexcept {
  return offer(frame, session.modes(), session.sub_steps(), session.primitives(), session.events());
}
bool Recorder::offer(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
                     std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) noexcept {
  return ring_->offer(frame, modes, sub_steps, placed, events);
}
void Recorder::make_resident() noexcept { ring_->make_resident(); }
void Recorder::keep_up(std::int64_t most_pending_ticks) { ring_->keep_up(most_pending_ticks); }
void Recorder::finish() { ring_->finish(); }

}  // namespace palpa
