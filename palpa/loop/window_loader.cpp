#include "palpa/loop/window_loader.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/base/wording.h"
#include "palpa/data/octave_parts.h"
#include "palpa/device/blocked_signals.h"

namespace palpa {
namespace {

// Poll interval of an idle loader. Longer: windows are late; shorter: more wake-ups.
constexpr auto idle_interval = std::chrono::milliseconds(1);
// Nice value of the thread. More: a busy machine makes no windows; less: they delay a loop without real-time priority.
constexpr int nice_value = 5;
// [s] of windows wanted without a pause, until a sentence reports it. Longer: late; shorter: each fast motion is reported.
constexpr double behind_s = 3.0;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// File of the volume that has this field.
std::string name_of(const Octaves& of, const Scene& scene) {
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) {
      const std::vector<const Octaves*> frames = frames_in_octaves(*field.field);
      if (std::ranges::find(frames, &of) == frames.end()) continue;
      return volume.volume.files.empty() ? volume.name : detail::one_line(volume.volume.files.front().path);
    }
  }
  return "data";
}

}  // namespace

WindowLoader::WindowLoader() {
  const detail::BlockedSignals in_the_thread;
  thread_ = std::thread([this] { run(); });
}

WindowLoader::~WindowLoader() {
  ends_.store(true, std::memory_order_relaxed);
  thread_.join();
}

std::uint32_t WindowLoader::add(const Scene& scene, const Stock& stock) {
  auto added = std::make_unique<Loading>(0u, scene, WindowPolicy(stock));
  const std::lock_guard lock(mutex_);
  added->number = ++scenes_;
  added_.push_back(std::move(added));
  return scenes_;
}

LoopStatistics::Windows WindowLoader::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void WindowLoader::run() {
  ::setpriority(PRIO_PROCESS, 0, nice_value);  // of this thread alone
  while (!ends_.load(std::memory_order_relaxed))
    if (!step()) std::this_thread::sleep_for(idle_interval);
}

/// Makes the next window; false: none is needed, or the loop has not taken the last one yet.
bool WindowLoader::step() {
  free_unused();
  const Motion motion = motion_.take();
  Loading* const loading = inbox_.load(std::memory_order_relaxed) ? nullptr : loading_of(motion);
  if (!loading) return false;
  const std::optional<WindowPlace> place = loading->policy.next(motion.feet);
  note_delay(place ? &*place : nullptr, now_s());
  if (place) make(*loading, *place);
  return place.has_value();
}

/// The loaded scene of a motion; nullptr before the first.
WindowLoader::Loading* WindowLoader::loading_of(const Motion& motion) {
  if (motion.scene == 0) return nullptr;
  if (!current_ || current_->number != motion.scene) {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find_if(added_, [&](const auto& one) { return one->number == motion.scene; });
    if (found == added_.end()) return nullptr;
    std::unique_ptr<Loading> next = std::move(*found);
    std::erase_if(added_, [&](const auto& one) { return !one || one->number < motion.scene; });
    if (current_) next->policy.take_over(current_->policy);
    current_ = std::move(next);
  }
  if (current_loop_ != std::exchange(current_loop_, motion.loop)) current_->policy.forget();
  return current_.get();
}

void WindowLoader::make(Loading& loading, const WindowPlace& place) {
  const double begin_s = now_s();
  OctaveWindow window;
  if (std::ranges::find(failed_, place.of) == failed_.end()) {
    try {
      window = place.of->window(place.octave, place.first, place.dims);
    } catch (const std::exception& error) {
      failed_.push_back(place.of);
      add_note(std::string(error.what()) + "; it is felt by the windows that are in memory");
    }
    for (const std::string& sentence : place.of->shape().source->problems_from(problems_noted_[place.of])) {
      ++problems_noted_[place.of];
      add_note(sentence);
    }
  }
  {
    const std::lock_guard lock(mutex_);
    counts_.busy_s += now_s() - begin_s;
    ++(window.grid ? counts_.made : counts_.lost);
  }
  if (!window.grid) return loading.policy.lost(place);
  loading.policy.made(place);
  // A count of references of its own, of this loader and of sessions alone: other owners may keep the window as well.
  const auto owner = std::make_shared<const OctaveWindow>(window);
  auto loaded = std::make_unique<Loaded>();
  loaded->place = place;
  loaded->window = {std::shared_ptr<const detail::GridBase>(owner, owner->grid.get()), owner->noise};
  made_.push_back(std::move(loaded));
  inbox_.store(made_.back().get(), std::memory_order_release);
}

/// Reports once for each file that windows are wanted without a pause.
void WindowLoader::note_delay(const WindowPlace* place, double now_s) {
  const std::int64_t windows = counts_.made;  // written by this thread alone
  if (!place || behind_since_s_ < 0.0) behind_since_s_ = place ? now_s : -1.0, windows_then_ = windows;
  if (!place || now_s - behind_since_s_ < behind_s) return;
  const std::string name = name_of(*place->of, current_->scene);
  if (std::ranges::find(slow_, name) != slow_.end()) return;
  slow_.push_back(name);
  const double per_s = static_cast<double>(windows - windows_then_) / (now_s - behind_since_s_);
  add_note(
      detail::text("%s: the hand waits for its data: %.3g windows a second come, and more are needed; coarser octaves are "
                   "felt meanwhile",
                   name.c_str(), per_s));
}

/// Several fields of a store have the same sentences about its chunks.
void WindowLoader::add_note(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (std::ranges::find(counts_.notes, sentence) == counts_.notes.end()) counts_.notes.push_back(sentence);
}

void WindowLoader::free_unused() {
  std::erase_if(made_, [](const std::unique_ptr<Loaded>& one) {
    return one->is_given_back.load(std::memory_order_acquire) && one->window.grid.use_count() == 1;
  });
}

}  // namespace palpa
