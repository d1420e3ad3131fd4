// palpa-fetch: gives palpa-read-zarr the files of one store at a web address, and nothing else. The only program of the readers
// with a network; it parses no volume, keeps no file on a disk, and can write none.
#include <curl/curl.h>
#include <poll.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fetch_transfer.h"
#include "palpa/base/load_error.h"
#include "palpa/base/web_address.h"
#include "palpa/file/store_protocol.h"
#include "program.h"
#include "sandbox.h"

namespace palpa::reader {
namespace {

// Connections that are kept open, and so files at once. More: servers refuse some; fewer: round trips of 50 ms leave less than
// the 1400 chunks a second that a fast hand needs.
constexpr long most_connections = 32;
// [bytes] Of all files at once. More: a hostile server takes more memory; less: large chunks come one by one.
constexpr std::uint64_t most_bytes_at_once = 512'000'000;
constexpr std::size_t most_waiting = 4096;
constexpr int look_every_ms = 1000;
// Attempts after wrong answers: a stock, and a share of the files that come. More: a server that cuts all files short holds
// windows up; fewer: a busy one loses chunks.
constexpr double most_further_attempts = 20.0, further_attempts_of_file = 0.2;

/// Whether a name is that of a file in a store: no way out of it.
bool is_name(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find("//") != name.npos) return false;
  const std::string within = "/" + name + "/";
  return within.find("/../") == within.npos && within.find("/./") == within.npos &&
         std::ranges::all_of(name, [](char c) { return static_cast<unsigned char>(c) > 0x1f && c != 0x7f; });
}

class Fetcher {
 public:
  Fetcher(int socket, std::string base) : socket_(socket), base_(std::move(base)), multi_(::curl_multi_init()) {
    if (multi_ == nullptr) throw std::bad_alloc();
    ::curl_multi_setopt(multi_, CURLMOPT_MAX_TOTAL_CONNECTIONS, most_connections);
    ::curl_multi_setopt(multi_, CURLMOPT_MAXCONNECTS, most_connections);
  }

  /// Serves until all other ends of the socket are closed.
  void run() {
    while (take_requests()) {
      begin_waiting();
      int running = 0;
      ::curl_multi_perform(multi_, &running);
      end_finished();
      begin_waiting();
      curl_waitfd request{socket_, CURL_WAIT_POLLIN, 0};
      ::curl_multi_poll(multi_, &request, 1, patience_ms(), nullptr);
    }
  }

 private:
  using Clock = FetchTransfer::Clock;
  using Transfer = std::unique_ptr<FetchTransfer>;

  /// Requests that have come. False: the other end is closed.
  bool take_requests() {
    for (pollfd ready{socket_, POLLIN, 0}; ::poll(&ready, 1, 0) > 0;) {
      bool garbled = false;
      const auto received = protocol::receive(socket_, garbled);
      const auto* request = received ? std::get_if<protocol::FetchRequest>(&received->message) : nullptr;
      if (request == nullptr || waiting_.size() >= most_waiting) return false;
      waiting_.push_back(std::make_unique<FetchTransfer>(base_, *request));
      const bool is_sound = is_name(request->name) && request->bytes <= protocol::most_whole_file_bytes &&
                            request->first <= INT64_MAX - request->bytes;
      if (is_sound) continue;
      waiting_.back()->fail("is no file of a store");
      give(*waiting_.back());
      waiting_.pop_back();
    }
    return true;
  }

  void give(const FetchTransfer& done) { protocol::send(socket_, done.answer(), done.descriptor()); }

  /// Begins what waits, as far as there are connections and memory for it.
  void begin_waiting() {
    for (auto next = waiting_.begin(); next != waiting_.end();) {
      if ((*next)->age_s() > protocol::longest_fetch_s) {
        (*next)->fail("its server is too slow for all that is asked of it");
        give(**next);
        next = waiting_.erase(next);
        continue;
      }
      const bool has_room = active_.empty() || bytes_ + (*next)->most_bytes() <= most_bytes_at_once;
      if (active_.size() >= static_cast<std::size_t>(most_connections) || !has_room) return;
      if ((*next)->not_before() > Clock::now()) {
        ++next;
        continue;
      }
      begin(std::move(*next));
      next = waiting_.erase(next);
    }
  }

  void begin(Transfer transfer) {
    CURL* handle = nullptr;
    if (free_.empty()) {
      handle = ::curl_easy_init();
      if (handle == nullptr) throw std::bad_alloc();
    } else {
      handle = free_.back();
      free_.pop_back();
    }
    transfer->begin(handle);
    ::curl_multi_add_handle(multi_, handle);
    bytes_ += transfer->most_bytes();
    active_.emplace(handle, std::move(transfer));
  }

  void end_finished() {
    int left = 0;
    while (const CURLMsg* message = ::curl_multi_info_read(multi_, &left)) {
      if (message->msg != CURLMSG_DONE) continue;
      CURL* const handle = message->easy_handle;
      const CURLcode code = message->data.result;
      const auto found = active_.find(handle);
      Transfer transfer = std::move(found->second);
      active_.erase(found);
      bytes_ -= transfer->most_bytes();
      const bool is_done = transfer->end(code, server_answers_, further_attempts_ >= 1.0);
      // Once it is given up, no file is tried again until one comes: else each would hold windows up for as long.
      if (transfer->was_answered() || is_done) server_answers_ = transfer->was_answered();
      if (!is_done && transfer->was_answered()) further_attempts_ -= 1.0;
      if (transfer->descriptor() >= 0)
        further_attempts_ = std::min(further_attempts_ + further_attempts_of_file, most_further_attempts);
      ::curl_multi_remove_handle(multi_, handle);
      free_.push_back(handle);
      if (is_done) {
        give(*transfer);
      } else {
        waiting_.push_front(std::move(transfer));
      }
    }
  }

  /// [ms] Until a waiting transfer may begin.
  int patience_ms() const {
    int patience = look_every_ms;
    for (const Transfer& transfer : waiting_) {
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(transfer->not_before() - Clock::now()).count();
      if (wait > 0) patience = static_cast<int>(std::min<std::int64_t>(patience, wait));
    }
    return patience;
  }

  int socket_;
  std::string base_;
  CURLM* multi_;
  std::deque<Transfer> waiting_;
  std::map<CURL*, Transfer> active_;
  std::vector<CURL*> free_;
  std::uint64_t bytes_ = 0;  ///< that the active ones may take
  bool server_answers_ = false;
  double further_attempts_ = most_further_attempts;  ///< [1] after wrong answers, that are left
};

void fetch_for_caller(int socket) {
  const protocol::Request request = receive_request(socket, true);
  enter_cage_with_network();
  if (!is_web_address(request.path) || !detail::problem_with_web_address(request.path).empty())
    throw LoadError("cannot be fetched: palpa-fetch was given no web address; update all programs together");
  std::string base = request.path;
  base.resize(base.find_last_not_of('/') + 1);
  if (::curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
    throw LoadError("cannot be fetched: libcurl does not start; install it anew");
  Fetcher(socket, std::move(base)).run();
}

}  // namespace
}  // namespace palpa::reader

int main() { return palpa::reader::run_program(palpa::reader::fetch_for_caller); }
