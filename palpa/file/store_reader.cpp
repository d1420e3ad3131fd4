#include "palpa/file/store_reader.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>
#include <vector>

#include "palpa/base/free_memory.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/wording.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_memory.h"
#include "palpa/file/reader_process.h"
#include "palpa/file/shared_memory.h"
#include "palpa/file/store_protocol.h"

namespace palpa {
namespace {

/// Resident memory of the program beside the slots: indices of shards, chunks being decoded. More: a damaged store can take
/// more; less: stores of large chunks are refused.
constexpr std::uint64_t reader_bytes = 2'000'000'000;
/// No computing beside the idle limit: the program itself ends at chunks that take longer than a second, up to eight at once.
constexpr std::uint64_t work_bytes = 0;
/// Longest wait for a chunk whose bytes arrive, in idle limits. Longer: an endless file lasts longer; shorter: slow networks
/// are taken for hung ones.
constexpr double most_idle_limits = 6.0;
constexpr double look_every_s = 0.1;
constexpr std::size_t longest_sentence_bytes = 2000;

/// Sentence of the program, which has parsed a store that may be malicious.
std::string sentence_of(const protocol::Failure& failure) {
  if (failure.sentence.find("; ") != std::string::npos) return failure.sentence;
  return "cannot be read: palpa-read says " + detail::in_quotes(failure.sentence) + "; the store is probably damaged";
}

[[noreturn]] void refuse_turn() {
  throw LoadError("cannot be read: palpa-read answered out of turn; update both programs together");
}

}  // namespace

class StoreReader::State {
 public:
  State(const std::filesystem::path& store, const ReadOptions& options, int slots)
      : place_(detail::one_line(store.string())),
        idle_limit_s_(detail::idle_limit_s(store, options)),
        pending_(static_cast<std::size_t>(slots)) {
    guarded([&] { open(store, options); });
  }
  State(const std::filesystem::path& file, const ReadOptions& options, int slots,
        std::unique_ptr<detail::ReaderProcess> process, StoreContents contents)
      : place_(detail::one_line(file.string())),
        idle_limit_s_(options.idle_limit_s),
        process_(std::move(process)),
        contents_(std::move(contents)),
        pending_(static_cast<std::size_t>(slots)) {
    guarded([&] { make_room(most_bytes(options)); });
  }

  const StoreContents& contents() const noexcept { return contents_; }
  int slots() const noexcept { return static_cast<int>(pending_.size()); }

  void request(const StoreChunk& chunk, int slot) {
    if (slot < 0 || slot >= slots() || !protocol::has_place(contents_, chunk))
      throw std::invalid_argument("StoreReader::request: no such slot or chunk");
    Pending& into = pending_[static_cast<std::size_t>(slot)];
    if (into.is_pending) throw std::invalid_argument("StoreReader::request: the slot has a request pending");
    guarded([&] {
      if (count_pending_ == 0) process().begin_work();
      if (!process().send(protocol::ChunkRequest{chunk, slot})) report_end();
    });
    into = {chunk, true};
    ++count_pending_;
  }

  std::optional<StoreRead> next(double timeout_s) {
    std::optional<StoreRead> read;
    guarded([&] {
      using Clock = std::chrono::steady_clock;
      const Clock::time_point latest = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                          std::chrono::duration<double>(std::clamp(timeout_s, 0.0, 1e6)));
      do {
        const double left_s = std::chrono::duration<double>(latest - Clock::now()).count();
        const auto message = process().receive_within(std::clamp(left_s, 0.0, look_every_s));
        if (message) {
          read = accepted(*message);
          return;
        }
        watch();
      } while (Clock::now() < latest);
    });
    return read;
  }

  std::span<const std::byte> content(int slot) const noexcept {
    const auto n = static_cast<std::size_t>(slot);
    if (slot < 0 || n >= pending_.size() || !map_) return {};
    return {map_.get() + n * slot_bytes_, static_cast<std::size_t>(protocol::content_bytes(contents_, pending_[n].chunk))};
  }

  int descriptor() const noexcept { return process_ ? process_->socket() : -1; }

 private:
  struct Pending {
    StoreChunk chunk;  ///< the latest of the slot
    bool is_pending = false;
  };

  /// Runs `act`; after its fault the program is ended, and all further calls throw the first sentence.
  template <class Act>
  void guarded(const Act& act) {
    try {
      act();
    } catch (const LoadError& error) {
      fail(error.what());
    } catch (const std::bad_alloc&) {
      fail("cannot be read: no memory for its chunks; request fewer at once");
    }
  }
  [[noreturn]] void fail(const std::string& sentence) {
    if (problem_.empty()) problem_ = detail::shortened(detail::one_line(sentence), longest_sentence_bytes);
    process_.reset(), fetch_.reset();
    throw LoadError(place_ + ": " + problem_);
  }
  detail::ReaderProcess& process() {
    if (!process_) throw LoadError(problem_);
    return *process_;
  }

  void open(const std::filesystem::path& store, const ReadOptions& options) {
    fetch_ = detail::start_fetch(store, options);
    process_ = std::make_unique<detail::ReaderProcess>(detail::find_reader(options.reader), idle_limit_s_, options.stop);
    protocol::Request ask;
    ask.path = store.string(), ask.store = true, ask.checksums = Checksums::none;
    ask.max_bytes = most_bytes(options);
    process_->send(ask, {fetch_ ? fetch_->socket() : -1, -1});
    protocol::Message answer = process_->receive(0, reader_bytes);
    if (const auto* failure = std::get_if<protocol::Failure>(&answer)) throw LoadError(sentence_of(*failure));
    if (!std::holds_alternative<StoreContents>(answer)) refuse_turn();
    contents_ = std::move(std::get<StoreContents>(answer));
    if (const char* problem = protocol::problem_with(contents_))
      throw LoadError(std::string(problem) + "; write the store again, or convert it by palpa convert");
    for (std::string& warning : contents_.warnings) warning = detail::one_line(warning);
    make_room(ask.max_bytes);
  }

  static std::uint64_t most_bytes(const ReadOptions& options) {
    return options.max_bytes != 0 ? options.max_bytes : detail::free_memory_bytes() / 3 * 2;
  }

  void make_room(std::uint64_t most) {
    slot_bytes_ = protocol::slot_bytes(contents_);
    const std::uint64_t bytes = slot_bytes_ * pending_.size();
    if (bytes > most) {
      throw LoadError("has chunks of " + protocol::readable_bytes(static_cast<double>(slot_bytes_)) + ", of which " +
                      std::to_string(pending_.size()) + " at once need more memory than is allowed; request fewer at once");
    }
    detail::SharedMemory memory(bytes);
    map_ = protocol::mapped(memory.files(), bytes, false).all;
    process_->send(protocol::StoreRoom{slots(), slot_bytes_}, memory.files());
  }

  /// The answer to a pending request.
  StoreRead accepted(const protocol::Message& message) {
    if (const auto* failure = std::get_if<protocol::Failure>(&message)) throw LoadError(sentence_of(*failure));
    const auto* answer = std::get_if<protocol::ChunkAnswer>(&message);
    if (answer == nullptr || answer->slot < 0 || answer->slot >= slots()) refuse_turn();
    Pending& of = pending_[static_cast<std::size_t>(answer->slot)];
    if (!of.is_pending || of.chunk != answer->chunk) refuse_turn();
    of.is_pending = false;
    --count_pending_;
    process().begin_work();
    return {answer->chunk, answer->slot, answer->state, answer->bytes,
            detail::shortened(detail::one_line(answer->sentence), longest_sentence_bytes)};
  }

  void watch() {
    if (count_pending_ == 0) return;
    process().watch(work_bytes, reader_bytes + slot_bytes_ * pending_.size());
    if (process().working_s() > most_idle_limits * idle_limit_s_)
      throw LoadError("cannot be read: palpa-read finished no chunk for " +
                      detail::text("%g s", most_idle_limits * idle_limit_s_) + " and was ended; check that the disk answers");
  }

  /// Throws the sentence of a program that has ended, which may be in the socket still.
  [[noreturn]] void report_end() {
    while (const auto message = process().receive_within(0.0)) {
      if (const auto* failure = std::get_if<protocol::Failure>(&*message)) throw LoadError(sentence_of(*failure));
    }
    process().report_end();
  }

  std::string place_;
  double idle_limit_s_;
  std::string problem_;                           ///< first fault; empty: none
  std::unique_ptr<detail::ReaderProcess> fetch_;  ///< of a web address; else null
  std::unique_ptr<detail::ReaderProcess> process_;
  StoreContents contents_;
  std::uint64_t slot_bytes_ = 0;
  std::shared_ptr<const std::byte> map_;
  std::vector<Pending> pending_;
  std::size_t count_pending_ = 0;
};

StoreReader::StoreReader(const std::filesystem::path& store, const ReadOptions& options, int slots) {
  if (slots < 1 || slots > protocol::most_slots) throw std::invalid_argument("StoreReader: 1 to 65536 slots");
  state_ = std::make_unique<State>(store, options, slots);
}
StoreReader::StoreReader(const std::filesystem::path& file, const ReadOptions& options, int slots,
                         std::unique_ptr<detail::ReaderProcess> process, StoreContents contents)
    : state_(std::make_unique<State>(file, options, slots, std::move(process), std::move(contents))) {}
StoreReader::~StoreReader() = default;

const StoreContents& StoreReader::contents() const noexcept { return state_->contents(); }
int StoreReader::slots() const noexcept { return state_->slots(); }
void StoreReader::request(const StoreChunk& chunk, int slot) { state_->request(chunk, slot); }
std::optional<StoreRead> StoreReader::next(double timeout_s) { return state_->next(timeout_s); }
std::span<const std::byte> StoreReader::content(int slot) const noexcept { return state_->content(slot); }
int StoreReader::descriptor() const noexcept { return state_->descriptor(); }

}  // namespace palpa
