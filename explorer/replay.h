// Hands that are felt again for the player: in the open scene, in it as it was changed, and in another trace's.
#pragma once

#include <QObject>
#include <filesystem>
#include <memory>
#include <vector>

#include "explorer/document.h"
#include "explorer/jobs.h"
#include "explorer/player.h"

namespace palpa::explorer {

/// One hand at a time, and beside it at most one more. For the window's thread.
class Replay : public QObject {
  Q_OBJECT
 public:
  Replay(Player& player, Jobs& jobs, const Document& document, std::vector<std::filesystem::path> data_folders,
         QObject* parent);

  /// Feels a hand in the open scene; the player shows it in place of another.
  /// \param second_trace  shown beside it as soon as it is there; empty: none
  void play(const PlayedHand& hand, const std::filesystem::path& second_trace = {});
  /// Feels the hand in the open scene as it is now, and shows that beside it: what if?
  void feel_changed_scene();
  /// Shows a second trace, of its own scene, beside the hand.
  void compare_with(const std::filesystem::path& trace);
  /// The player shows nothing more.
  void end();

 Q_SIGNALS:
  /// The player shows the hand.
  void shown();
  /// The hand could not be felt; `said` told why.
  void failed();
  void said(const QString& words, bool is_problem);

 private:
  void show_beside(FeltTrace second);

  Player& player_;
  Jobs& jobs_;
  const Document& document_;
  const std::vector<std::filesystem::path> data_folders_;
  PlayedHand hand_;
  std::shared_ptr<const FeltTrace> felt_;  ///< null: nothing was felt yet
};

}  // namespace palpa::explorer
