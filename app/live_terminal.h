// Status line and control keys of a live run on a terminal.
#pragma once

#include <termios.h>

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "palpa/loop/loop.h"

namespace palpa::app {

/// Rewrites one line on stderr, and handles keys: q ends, others are passed on. No line unless stderr is a terminal; no keys
/// unless stdin is, with the program in the foreground. Only one at a time; one thread.
class LiveTerminal {
 public:
  /// \param keys  sentence about the keys
  explicit LiveTerminal(const char* keys = "Keys: space turns the force off and on, 1 to 9 turn modes on and off, q ends.");
  ~LiveTerminal();  ///< erases the line
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;

  /// Updates the line and handles keys once, some fifty times a second; false: q was pressed.
  bool watch(const std::function<std::string()>& line, const std::function<void(char)>& obey);
  /// Likewise of a loop: its timing, the force and the guard's state; space switches the force off and on, 1 to 9 toggle modes.
  /// \param scenes  one for each hand; the line is of the first
  bool watch(LiveLoop& loop, std::span<LiveScene* const> scenes);

  /// Whether there is a line.
  bool shows() const noexcept { return shows_; }
  /// Erases the line until the next `watch`, so that others can be printed.
  void erase_line() noexcept;

 private:
  void take_keys();
  void obey(char key, LiveLoop& loop, std::span<LiveScene* const> scenes);

  static constexpr int looks_per_line = 5;

  bool shows_ = false;
  int looks_ = 0;
  bool is_held_ = false;           // by the panic key
  std::optional<termios> before_;  // of a stdin whose keys are read; none: keys are not read
};

}  // namespace palpa::app
