#include "explorer/replay.h"

#include "explorer/opening.h"
#include "palpa/base/load_error.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

Replay::Replay(Player& player, Jobs& jobs, const Document& document, std::vector<fs::path> data_folders, QObject* parent)
    : QObject(parent), player_(player), jobs_(jobs), document_(document), data_folders_(std::move(data_folders)) {}

void Replay::play(const PlayedHand& hand, const fs::path& second_trace) {
  hand_ = hand;
  felt_.reset();
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("replaying the trace"),
      [hand, loaded = document_.loaded()](std::stop_token stop) { return feel_again(hand, loaded, stop); },
      [this, second_trace](FeltTrace felt) {
        felt_ = std::make_shared<const FeltTrace>(std::move(felt));
        player_.show_trace(felt_);
        Q_EMIT shown();
        if (!second_trace.empty()) compare_with(second_trace);
      },
      [this](const QString& why) {
        Q_EMIT said(why, true);
        Q_EMIT failed();
      });
}

void Replay::feel_changed_scene() {
  PlayedHand hand = hand_;
  if (hand.trace.empty()) hand.again = felt_;  // a simulated hand would take another path in another scene
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("replaying in the changed scene"),
      [hand, loaded = document_.loaded()](std::stop_token stop) { return feel_again(hand, loaded, stop); },
      [this](FeltTrace felt) {
        felt.name = tr("in the changed scene").toStdString();
        show_beside(std::move(felt));
      },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

void Replay::compare_with(const fs::path& trace) {
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("replaying the second trace"),
      [trace, folders = data_folders_](std::stop_token stop) {
        const Opened opened = open_any(trace, folders, stop);
        if (opened.trace.empty()) throw LoadError(trace.string() + ": is no trace; choose the trace.toml of one");
        return feel_again({.trace = trace, .description = {}}, opened.loaded, stop);
      },
      [this](FeltTrace felt) { show_beside(std::move(felt)); }, [this](const QString& why) { Q_EMIT said(why, true); });
}

void Replay::end() {
  player_.show_trace({});
  felt_.reset();
}

void Replay::show_beside(FeltTrace second) {
  if (!felt_) return;
  const double at_s = player_.at_s();
  player_.show_trace(felt_, std::make_shared<const FeltTrace>(std::move(second)));
  player_.seek(at_s);
}

}  // namespace palpa::explorer
