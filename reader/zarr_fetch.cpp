#include "zarr_fetch.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <thread>
#include <utility>

#include "palpa/base/load_error.h"
#include "palpa/file/store_protocol.h"

namespace palpa::reader {
namespace {

// Files of parts whose begin or end is in memory, each by a descriptor, and what they take. More: no descriptors, no memory;
// less: they are fetched again.
constexpr std::size_t most_kept = 256;
constexpr std::uint64_t most_bytes_kept = 256'000'000;
constexpr std::size_t most_forbidden = 4096;  ///< More: memory; fewer: some metadata are refused with another sentence

/// Bytes at `from` of a file in memory, as many as there are. Never throws.
std::size_t read_from(int descriptor, std::uint64_t from, void* to, std::size_t bytes) noexcept {
  std::size_t got = 0;
  while (got < bytes) {
    const ssize_t n = ::pread(descriptor, static_cast<char*>(to) + got, bytes - got, static_cast<off_t>(from + got));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    got += static_cast<std::size_t>(n);
  }
  return got;
}

/// Size of a regular file; 0 of anything else, which a sound palpa-fetch does not send.
std::uint64_t bytes_behind(int descriptor) noexcept {
  struct stat status{};
  if (descriptor < 0 || ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return 0;
  return static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
}

LoadError failure(const std::string& name, const std::string& sentence) { return LoadError("'" + name + "': " + sentence); }

/// A file that has come as a whole.
class WholeFile final : public ZarrFile {
 public:
  explicit WholeFile(std::shared_ptr<const int> descriptor)
      : descriptor_(std::move(descriptor)), bytes_(bytes_behind(*descriptor_)) {}
  std::uint64_t bytes() const noexcept override { return bytes_; }
  std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const override {
    return from >= bytes_ ? 0 : read_from(*descriptor_, from, to, std::min<std::uint64_t>(bytes, bytes_ - from));
  }

 private:
  std::shared_ptr<const int> descriptor_;
  std::uint64_t bytes_;
};

}  // namespace

/// A file whose begin or end has come; the rest is fetched by each `read`.
class PartsOfFile final : public ZarrFile {
 public:
  PartsOfFile(ZarrFetch& fetch, std::string name, std::uint64_t first, std::uint64_t bytes, std::shared_ptr<const int> known)
      : fetch_(fetch), name_(std::move(name)), first_(first), bytes_(bytes), known_(std::move(known)) {}
  std::uint64_t bytes() const noexcept override { return bytes_; }
  std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const override {
    if (from >= bytes_) return 0;
    bytes = std::min<std::uint64_t>(bytes, bytes_ - from);
    const std::uint64_t there = bytes_behind(*known_);
    if (from >= first_ && from - first_ <= there && bytes <= there - (from - first_))
      return read_from(*known_, from - first_, to, bytes);
    if (bytes == 0) return 0;
    const ZarrFetch::Answer part =
        fetch_.get({.name = name_, .first = from, .bytes = bytes, .most_bytes = protocol::most_whole_file_bytes});
    if (part.message.state == protocol::FetchState::absent) throw failure(name_, "is gone from its server");
    if (part.message.state != protocol::FetchState::present) throw failure(name_, part.message.sentence);
    if (part.message.whole_bytes != bytes_ || part.message.first > from)
      throw failure(name_, "has changed on its server since it was first read");
    return read_from(*part.descriptor, from - part.message.first, to, bytes);
  }

 private:
  ZarrFetch& fetch_;
  std::string name_;
  std::uint64_t first_, bytes_;
  std::shared_ptr<const int> known_;
};

ZarrFetch::ZarrFetch(int socket) : socket_(socket) {
  std::thread([this] { take_answers(); }).detach();  // ends with the process, as this object does
}

void ZarrFetch::take_answers() {
  bool garbled = false;
  std::string sentence = "cannot be fetched: palpa-fetch has ended; open it again";
  while (true) {
    auto received = protocol::receive(socket_, garbled);
    if (!received) break;
    if (received->second_descriptor >= 0) ::close(received->second_descriptor);
    const std::shared_ptr<const int> descriptor(new int(received->descriptor), [](const int* file) {
      if (*file >= 0) ::close(*file);
      delete file;
    });
    if (const auto* why = std::get_if<protocol::Failure>(&received->message)) sentence = why->sentence;
    auto* answer = std::get_if<protocol::FetchAnswer>(&received->message);
    if (answer == nullptr) break;
    if (answer->state == protocol::FetchState::present && *descriptor < 0) break;
    const std::scoped_lock lock(mutex_);
    const auto found = pending_.find(answer->number);
    if (found == pending_.end()) break;
    found->second = Answer{std::move(*answer), descriptor};
    came_.notify_all();
  }
  if (garbled) sentence = "cannot be fetched: palpa-fetch is of another version; update all programs together";
  protocol::send(protocol::socket_descriptor, protocol::Failure{sentence});
  ::_exit(1);
}

ZarrFetch::Answer ZarrFetch::get(protocol::FetchRequest request) {
  std::unique_lock lock(mutex_);
  request.number = ++last_;
  pending_[request.number];
  lock.unlock();
  protocol::send(socket_, request);  // an end that is closed ends this process
  lock.lock();
  came_.wait(lock, [&] { return pending_[request.number].has_value(); });
  Answer answer = std::move(*pending_[request.number]);
  pending_.erase(request.number);
  if (answer.message.is_forbidden && forbidden_.size() < most_forbidden) forbidden_.insert(request.name);
  return answer;
}

std::unique_ptr<ZarrFile> ZarrFetch::whole(const std::string& name, std::uint64_t most_bytes) {
  const Answer answer = get({.name = name, .most_bytes = most_bytes});
  if (answer.message.state == protocol::FetchState::absent) return nullptr;
  if (answer.message.state != protocol::FetchState::present) throw failure(name, answer.message.sentence);
  return std::make_unique<WholeFile>(answer.descriptor);
}

std::shared_ptr<const ZarrFile> ZarrFetch::in_parts(const std::string& name, std::uint64_t known_bytes, bool at_end) {
  std::promise<std::shared_ptr<const ZarrFile>> promise;
  {
    std::unique_lock lock(mutex_);
    if (const auto found = parts_.find(name); found != parts_.end()) {
      const auto there = found->second;
      lock.unlock();
      return there.get();  // blocks for the thread that fetches it
    }
    if (parts_.size() >= most_kept || bytes_of_parts_ > most_bytes_kept) parts_.clear(), bytes_of_parts_ = 0;
    parts_.emplace(name, promise.get_future().share());
  }
  try {
    const Answer answer =
        get({.name = name, .bytes = known_bytes, .from_end = at_end, .most_bytes = protocol::most_whole_file_bytes});
    if (answer.message.state == protocol::FetchState::failed) throw failure(name, answer.message.sentence);
    std::shared_ptr<const ZarrFile> made;  // null: absent, which stays so
    if (answer.message.state == protocol::FetchState::present)
      made = std::make_shared<PartsOfFile>(*this, name, answer.message.first, answer.message.whole_bytes, answer.descriptor);
    promise.set_value(made);
    const std::scoped_lock lock(mutex_);
    bytes_of_parts_ += bytes_behind(*answer.descriptor);
    return made;
  } catch (...) {
    promise.set_exception(std::current_exception());
    const std::scoped_lock lock(mutex_);
    parts_.erase(name);  // the next one tries again
    throw;
  }
}

bool ZarrFetch::was_forbidden(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  return forbidden_.contains(name);
}

bool ZarrFetch::has_forbidden() const {
  const std::scoped_lock lock(mutex_);
  return !forbidden_.empty();
}

}  // namespace palpa::reader
