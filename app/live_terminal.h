// A live run on a terminal: how it goes, and keys that steer it.
#pragma once

#include <termios.h>

#include <optional>

#include "palpa/loop/loop.h"

namespace palpa::app {

/// Says on stderr, on one line that is written over and over, how the loop keeps time and what is felt, and obeys keys: space
/// takes the force away and gives it back, 1 to 9 turn modes on and off, q ends. Where stderr or stdin is no terminal, that
/// half is left out; so are the keys while the program is in the background of its terminal. Only one at a time; one thread.
class LiveTerminal {
 public:
  LiveTerminal();
  ~LiveTerminal();  ///< wipes the line
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;

  /// Shows and obeys once; false: q was pressed.
  bool watch(LiveLoop& loop, LiveScene& scene);

 private:
  void take_keys();
  void show(LiveLoop& loop);
  bool obey(char key, LiveLoop& loop, LiveScene& scene);

  static constexpr int looks_per_line = 5;

  bool shows_ = false;
  int looks_ = 0;
  bool is_held_ = false;           // by the panic key
  std::optional<termios> before_;  // of a stdin whose keys are read; none: they are not
};

}  // namespace palpa::app
