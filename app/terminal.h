// What goes to stderr: errors, warnings and progress, one line each.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::app {

void print_error(std::string_view message);
void print_warnings(const std::vector<std::string>& warnings);

/// How much is done and how long it will still take, on one line that is written over. Silent where
/// stderr is no terminal.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  ///< wipes the line
  void show(double share_done);

 private:
  std::string what_;
  bool on_terminal_;
  std::chrono::steady_clock::time_point begin_, shown_;
};

}  // namespace palpa::app
