// Replays hands for the player: in the open scene, in its changed version, and from a second trace.
#pragma once

#include <QObject>
#include <filesystem>
#include <memory>
#include <vector>

#include "explorer/document.h"
#include "explorer/jobs.h"
#include "explorer/player.h"

namespace palpa::explorer {

/// One hand at a time, the scene's others beside it, plus at most one for comparison. For the window's thread.
class Replay : public QObject {
  Q_OBJECT
 public:
  Replay(Player& player, Jobs& jobs, const Document& document, std::vector<std::filesystem::path> data_folders,
         QObject* parent);

  /// Replays a hand in the open scene and shows it in place of another.
  /// \param second_trace  shown beside it once loaded; empty: none
  void play(const PlayedHand& hand, const std::filesystem::path& second_trace = {});
  /// Likewise the hands of a run, in the scene's order; the first is led.
  void play(const std::vector<PlayedHand>& hands, const std::filesystem::path& second_trace = {});
  /// Number of played hands; 0: none yet.
  std::size_t hands() const { return felt_.size(); }
  /// Leads another of the played hands, at the same moment, without a comparison.
  void lead(std::size_t number);
  /// Replays the hand in the scene as it is now and shows the result beside the first.
  void feel_changed_scene();
  /// Shows a second trace, in its own scene, beside the hand.
  void compare_with(const std::filesystem::path& trace);
  /// Clears the player.
  void end();

 Q_SIGNALS:
  /// The player shows the hand.
  void shown();
  /// The replay failed; `said` gave the reason.
  void failed();
  void said(const QString& words, bool is_problem);

 private:
  void show_beside(FeltTrace second);

  Player& player_;
  Jobs& jobs_;
  const Document& document_;
  const std::vector<std::filesystem::path> data_folders_;
  std::vector<std::shared_ptr<const FeltTrace>> others() const;

  std::vector<PlayedHand> hands_;  ///< at least one while one is played
  std::size_t led_ = 0;
  std::vector<std::shared_ptr<const FeltTrace>> felt_;  ///< of `hands_`; empty: no replay yet
};

}  // namespace palpa::explorer
