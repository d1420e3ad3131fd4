// Files of a store at a web address, from palpa-fetch.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "palpa/file/protocol.h"
#include "zarr_file.h"

namespace palpa::reader {

class PartsOfFile;

/// The reader's end of palpa-fetch. Any number of threads request at once, and each blocks for its own file.
class ZarrFetch {
 public:
  /// Starts the thread that takes the answers. Its end of the socket closed ends this process, with a failure to the caller.
  /// \param socket  of palpa-fetch; stays open as long as the process
  explicit ZarrFetch(int socket);

  /// A whole file; null if there is none. Throws LoadError "'0/1/2': …".
  /// \param most_bytes  longer ones are refused
  std::unique_ptr<ZarrFile> whole(const std::string& name, std::uint64_t most_bytes);

  /// A file of which parts are read; null if there is none. Its `known_bytes` at the end or the begin come at once, and stay in
  /// memory for all who open it later: it must not change. A server that gives no parts gives the whole file. Throws as above.
  std::shared_ptr<const ZarrFile> in_parts(const std::string& name, std::uint64_t known_bytes, bool at_end);

  /// Whether the server has forbidden a file, or any: some servers do with files that are missing.
  bool was_forbidden(const std::string& name) const;
  bool has_forbidden() const;

 private:
  struct Answer {
    protocol::FetchAnswer message;
    std::shared_ptr<const int> descriptor;
  };
  Answer get(protocol::FetchRequest request);
  void take_answers();
  friend class PartsOfFile;

  int socket_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::uint32_t last_ = 0;
  std::map<std::uint32_t, std::optional<Answer>> pending_;
  std::map<std::string, std::shared_future<std::shared_ptr<const ZarrFile>>> parts_;
  std::uint64_t bytes_of_parts_ = 0;
  std::set<std::string> forbidden_;
};

}  // namespace palpa::reader
