// Output to stdout and stderr, sanitized, because names, titles and cells come from files.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace palpa::app {

/// To stdout: lines for people, or JSON.
void print(std::string_view text);
/// To stderr: lines that are neither error nor warning.
void tell(std::string_view text);

/// One line of at most 500 bytes, for any input.
void print_error(std::string_view message);
void print_warnings(const std::vector<std::string>& warnings);

/// Progress line on stderr during this object's lifetime: the share done and the time left, or the elapsed time. Begins after
/// half a second. Silent if stderr is no terminal. Only one at a time.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  ///< erases the line
  /// \param share_done  [1]
  void show(double share_done) noexcept { share_done_ = share_done; }

 private:
  void draw();

  std::string what_;
  std::atomic<double> share_done_ = 0.0;
  bool over_ = false;  // under mutex_
  std::mutex mutex_;
  std::condition_variable ends_;
  std::thread drawing_;
};

}  // namespace palpa::app
