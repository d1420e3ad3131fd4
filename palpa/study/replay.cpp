#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "palpa/loop/loop.h"
#include "palpa/loop/window_feed.h"
#include "palpa/loop/window_policy.h"
#include "palpa/mode/plugin.h"
#include "palpa/study/recorded_scene.h"
#include "palpa/study/recording.h"
#include "palpa/study/run.h"
#include "palpa/trace/windows.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    const fs::path parent = fs::temp_directory_path(error);
    std::string name = ((error ? fs::path("/tmp") : parent) / "palpa-replay-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw LoadError(name + ": cannot be made; set TMPDIR to a folder that can be written");
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Windows of volumes larger than memory in a replay: of a live run those that came, before the same ticks; of another those
/// of the finest octave. Chunks of the data must be those that were recorded.
class Windows {
 public:
  /// Throws LoadError on windows that the data cannot have.
  Windows(const TraceReader& reader, const fs::path& trace, const Scene& scene, Session& session) : session_(session) {
    if (session.stock().empty()) return;
    const std::vector<TracedField> fields = traced_fields(scene);
    const auto named = [&](const auto& row) {
      const auto found = std::ranges::find_if(fields, [&](const TracedField& field) {
        return field.volume == row.volume && field.field == row.field && field.frame == row.frame;
      });
      if (found == fields.end())
        throw LoadError(trace.string() + ": has windows of " + row.volume + "." + row.field +
                        ", a field that its scene has not in a volume larger than memory; record it again");
      return found->octaves;
    };
    for (const TracedChunks& chunks : traced_chunks(trace)) named(chunks)->shape().source->expect(chunks.sums);
    if (!reader.header().motors) {
      feed_.emplace(session);
      return;
    }
    for (TracedWindow& window : traced_windows(trace)) {
      window.place.of = named(window);
      if (!can_be_felt_live(window.place))
        throw LoadError((trace / "windows.csv").string() + ": the window before tick " + std::to_string(window.tick) +
                        " is not within the data, or too large; a recording has none such");
      recorded_.push_back(std::move(window));
    }
  }
  /// Lays what the tick needs. Returns the window of a live run.
  WindowPlace lay_for(std::int64_t tick, const Probe& probe, double dt_s) {
    if (feed_) feed_->lay_for(probe, dt_s);
    if (next_ == recorded_.size() || recorded_[next_].tick != tick) return {};
    const WindowPlace& place = recorded_[next_++].place;
    session_.stock().lay(*place.of, place.octave, place.of->window(place.octave, place.first, place.dims));
    return place;
  }

 private:
  Session& session_;
  std::optional<WindowFeed> feed_;
  std::vector<TracedWindow> recorded_;
  std::size_t next_ = 0;
};

}  // namespace

ReplayResult replay(const fs::path& trace, const std::vector<fs::path>& data_folders, const ReadOptions& read,
                    const std::atomic<bool>* stop, const std::vector<fs::path>& plugins,
                    const std::function<void(double)>& progress) {
  const TraceReader reader(trace);
  const TraceHeader& header = reader.header();
  if (plugins.empty() && !header.plugins.empty()) {
    throw LoadError((trace / "trace.toml").string() + ": was recorded with the plug-in " + header.plugins.front() +
                    "; name it with --plugin if you trust it");
  }
  const std::vector<TraceTick> ticks = reader.ticks();

  const LoadedScene loaded = load_recorded_scene(trace, reader, data_folders, read, modes_with(plugins));

  Session session(loaded.scene, header.device_encoder_step_m);
  const TemporaryFolder temporary;
  const fs::path again = temporary.path() / "trace";
  const auto writer = detail::new_trace(again, header, loaded.text, loaded.scene);

  ReplayResult result;
  SummaryBuilder builder(loaded.scene);
  GuardedSession guarded(session, detail::guard_options_of(header));
  Windows windows(reader, trace, loaded.scene, session);
  const auto begin = std::chrono::steady_clock::now();
  const TickFrame* before = nullptr;
  for (const auto& [recorded] : ticks) {
    // On a simulated clock no tick is lost and no scene changes.
    if (header.motors) result.cut = detail::what_cannot_be_felt_again(before, recorded, header.dt_s);
    if (!result.cut.empty()) break;
    before = &recorded;
    const Probe probe{.position_m = recorded.result.probe_m,
                      .velocity_m_per_s = recorded.result.probe_velocity_m_per_s,
                      .valid = recorded.result.probe_valid,
                      .buttons = recorded.buttons,
                      .turn = recorded.result.probe_turn};
    const WindowPlace laid = windows.lay_for(recorded.tick, probe, recorded.dt_s);
    TickFrame frame = guarded.tick(recorded.tick, recorded.t_s, recorded.dt_s, probe, recorded.circumstances);
    frame.laid = laid;
    builder.add(frame, session);
    writer->append(frame, session.modes(), session.sub_steps(), session.primitives(), session.events());
    if (progress && recorded.tick % 1000 == 0) {
      progress(std::min(1.0, static_cast<double>(recorded.tick) / static_cast<double>(ticks.size())));
    }
    if (stop && stop->load()) break;
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  writer->finish();

  result.summary = builder.finish(wall.count());
  result.interrupted = stop && stop->load();
  if (!result.interrupted) {
    result.difference = result.cut.empty() ? compare_traces(trace, again) : compare_traces(trace, again, before->tick);
  }
  return result;
}

}  // namespace palpa
