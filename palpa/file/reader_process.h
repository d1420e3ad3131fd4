// The program palpa-read as a child of this one: started, watched, and never left behind.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

#include "palpa/file/protocol.h"
#include "palpa/file/protocol_memory.h"

namespace palpa::detail {

/// The program: `option`, else $PALPA_READER, else palpa-read beside this program or in ../libexec/palpa.
/// Throws LoadError, with a sentence, where it is not there.
std::filesystem::path find_reader(const std::filesystem::path& option);

/// Which parts of the cage that palpa-read closes around itself this system lacks, in its own words; empty: none, or there is
/// no palpa-read.
std::string lacking_of_cage();

/// One run of palpa-read. What it does wrong is a LoadError with a sentence, without the file's name.
/// The destructor ends it, with all that it started, and waits for its end: no descriptor and no zombie
/// is left, whatever happened.
class ReaderProcess {
 public:
  /// Starts the program.
  /// \param idle_limit_s  [s] without progress it is ended
  /// \param stop          once it is asked to stop it is ended, too
  ReaderProcess(const std::filesystem::path& program, double idle_limit_s, std::stop_token stop);
  ~ReaderProcess();
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;

  /// Sends a message, with memory for the reader. A reader that is gone is noticed by `receive`.
  void send(const protocol::Message& message, const protocol::MemoryFiles& with = {});

  /// Waits for the next message as long as the reader makes progress: it uses CPU time or reads bytes.
  /// \param work_bytes    what it has to work through: CPU time without a byte read counts as progress
  ///                      for idle_limit_s and a second more for each 20 MB of it
  /// \param memory_bytes  more resident memory than this, and it is ended
  protocol::Message receive(std::uint64_t work_bytes, std::uint64_t memory_bytes);

 private:
  void watch(std::uint64_t work_bytes, std::uint64_t memory_bytes);
  [[noreturn]] void report_end();
  int end() noexcept;  ///< kills and reaps; the status of wait, or -1

  double idle_limit_s_;
  std::stop_token stop_;
  int socket_ = -1;
  pid_t pid_ = -1;

  using Clock = std::chrono::steady_clock;
  Clock::time_point last_progress_ = Clock::now();
  std::uint64_t last_cpu_ticks_ = 0, last_bytes_read_ = 0;
  std::uint64_t cpu_ticks_at_read_ = 0;  ///< CPU time when a byte was last read
};

}  // namespace palpa::detail
