// palpa-read as a child process: started, monitored, and always reaped.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "palpa/file/protocol.h"
#include "palpa/file/protocol_memory.h"

namespace palpa::detail {

/// Path of the program: `option`, else $PALPA_READER, else palpa-read beside this program or in ../libexec/palpa. Throws
/// LoadError, with a sentence, if missing.
std::filesystem::path find_reader(const std::filesystem::path& option);

/// Parts of palpa-read's sandbox that this system lacks, in its own words; empty: none, or no palpa-read.
std::string lacking_of_cage();

/// Run of palpa-read. Its faults are a LoadError with a sentence, without the file's name. The destructor ends it with all its
/// children and reaps it: no descriptor is left in any case, and no zombie unless the system holds it for seconds, as on a
/// frozen mount.
class ReaderProcess {
 public:
  /// Starts the program.
  /// \param idle_limit_s  [s] without progress it is ended
  /// \param stop          a stop ends it, too
  ReaderProcess(const std::filesystem::path& program, double idle_limit_s, std::stop_token stop);
  ~ReaderProcess();
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;

  /// Sends a message, with memory for the reader. `receive` reports a reader that has ended. Throws LoadError if the reader
  /// leaves its messages unread for `idle_limit_s`.
  /// \return  false: the reader has ended
  bool send(const protocol::Message& message, const protocol::MemoryFiles& with = {});

  /// Blocks for the next message while the reader makes progress: it uses CPU time or reads bytes.
  /// \param work_bytes    amount of work: CPU time without a byte read counts as progress for idle_limit_s and a second more
  /// for each 20 MB of it
  /// \param memory_bytes  limit of resident memory
  protocol::Message receive(std::uint64_t work_bytes, std::uint64_t memory_bytes);

  /// Next message; none after `timeout_s` [s] without one. Throws LoadError if the reader has ended. Without supervision:
  /// callers with a request pending call `watch`, first after `begin_work`.
  std::optional<protocol::Message> receive_within(double timeout_s);
  /// Begins a piece of work, from which `watch` counts.
  void begin_work();
  /// Ends a reader without progress for too long, or too large; then throws LoadError. Parameters as of `receive`.
  void watch(std::uint64_t work_bytes, std::uint64_t memory_bytes);
  /// Time [s] since `begin_work`.
  double working_s() const noexcept;
  /// Readable when a message has arrived, for poll.
  int socket() const noexcept { return socket_; }
  /// Ends it, if it runs, and throws LoadError with the way it ended.
  [[noreturn]] void report_end();

 private:
  protocol::Message take();
  int end() noexcept;  ///< kills and reaps; the status of wait, or -1

  double idle_limit_s_;
  std::stop_token stop_;
  int socket_ = -1;
  pid_t pid_ = -1;

  using Clock = std::chrono::steady_clock;
  Clock::time_point last_progress_ = Clock::now(), begin_of_work_ = Clock::now();
  std::uint64_t last_cpu_ticks_ = 0, last_bytes_read_ = 0;
  std::uint64_t cpu_ticks_at_read_ = 0;  ///< CPU time of the last byte read, or of the first look at this piece of work
  bool is_new_work_ = true;
};

}  // namespace palpa::detail
