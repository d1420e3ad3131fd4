// Status line and control keys of a live run on a terminal.
#pragma once

#include <termios.h>

#include <optional>
#include <span>

#include "palpa/loop/loop.h"

namespace palpa::app {

/// Rewrites one line on stderr with the loop's timing, the force and the guard's state, and handles keys: space switches the
/// force off and on, 1 to 9 toggle modes, q ends. No line unless stderr is a terminal; no keys unless stdin is, with the
/// program in the foreground. Only one at a time; one thread.
class LiveTerminal {
 public:
  LiveTerminal();
  ~LiveTerminal();  ///< erases the line
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;

  /// Updates the line and handles keys once; false: q was pressed.
  /// \param scenes  one for each hand; the line is of the first
  bool watch(LiveLoop& loop, std::span<LiveScene* const> scenes);

 private:
  void take_keys();
  void show(LiveLoop& loop);
  bool obey(char key, LiveLoop& loop, std::span<LiveScene* const> scenes);

  static constexpr int looks_per_line = 5;

  bool shows_ = false;
  int looks_ = 0;
  bool is_held_ = false;           // by the panic key
  std::optional<termios> before_;  // of a stdin whose keys are read; none: keys are not read
};

}  // namespace palpa::app
