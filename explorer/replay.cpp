#include "explorer/replay.h"

#include "explorer/opening.h"
#include "palpa/base/load_error.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

Replay::Replay(Player& player, Jobs& jobs, const Document& document, std::vector<fs::path> data_folders, QObject* parent)
    : QObject(parent), player_(player), jobs_(jobs), document_(document), data_folders_(std::move(data_folders)) {}

void Replay::play(const PlayedHand& hand, const fs::path& second_trace) { play(std::vector{hand}, second_trace); }

void Replay::play(const std::vector<PlayedHand>& hands, const fs::path& second_trace) {
  hands_ = hands;
  led_ = 0;
  felt_.clear();
  jobs_.begin<std::vector<FeltTrace>>(
      Jobs::Purpose::feel_again, tr("replaying the trace"),
      [hands, loaded = document_.loaded()](std::stop_token stop) {
        std::vector<FeltTrace> felt;
        for (const PlayedHand& hand : hands) felt.push_back(feel_again(hand, loaded, stop));
        return felt;
      },
      [this, second_trace](std::vector<FeltTrace> felt) {
        for (FeltTrace& one : felt) felt_.push_back(std::make_shared<const FeltTrace>(std::move(one)));
        player_.show_trace(felt_[led_], {}, others());
        Q_EMIT shown();
        if (!second_trace.empty()) compare_with(second_trace);
      },
      [this](const QString& why) {
        Q_EMIT said(why, true);
        Q_EMIT failed();
      });
}

std::vector<std::shared_ptr<const FeltTrace>> Replay::others() const {
  std::vector<std::shared_ptr<const FeltTrace>> all = felt_;
  all.erase(all.begin() + static_cast<std::ptrdiff_t>(led_));
  return all;
}

void Replay::lead(std::size_t number) {
  if (number >= felt_.size()) return;
  const double at_s = player_.at_s();
  led_ = number;
  player_.show_trace(felt_[led_], {}, others());
  player_.seek(at_s);
}

void Replay::feel_changed_scene() {
  if (hands_.empty()) return;
  PlayedHand hand = hands_[led_];
  if (hand.trace.empty() && !felt_.empty())
    hand.again = felt_[led_];  // a simulated hand would take another path in another scene
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
      [trace, number = led_, folders = data_folders_](std::stop_token stop) {
        const Opened opened = open_any(trace, folders, stop);
        if (opened.trace.empty()) throw LoadError(trace.string() + ": is no trace; choose the trace.toml of one");
        const bool has_it = number < opened.hand_traces.size();
        return feel_again({.trace = has_it ? opened.hand_traces[number] : opened.trace, .number = has_it ? number : 0},
                          opened.loaded, stop);
      },
      [this](FeltTrace felt) { show_beside(std::move(felt)); }, [this](const QString& why) { Q_EMIT said(why, true); });
}

void Replay::end() {
  player_.show_trace({});
  hands_.clear();
  felt_.clear();
}

void Replay::show_beside(FeltTrace second) {
  if (felt_.empty()) return;
  const double at_s = player_.at_s();
  player_.show_trace(felt_[led_], std::make_shared<const FeltTrace>(std::move(second)), others());
  player_.seek(at_s);
}

}  // namespace palpa::explorer
