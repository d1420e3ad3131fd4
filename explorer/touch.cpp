#include "explorer/touch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace palpa::explorer {
namespace {

// Speed limit of the mouse's hand [m/s], well below that at which the guard releases. Faster: pushes are blows.
constexpr double led_m_per_s = 0.5;
// Likewise of its turns [rad/s]: a foot 0.15 m away is as fast.
constexpr double led_rad_per_s = 3.0;
// Radius [m] of the mouse's workspace: scenes are about 0.15 m large.
constexpr double pointer_radius_m = 0.4;

std::atomic<LiveRun*> felt_now{nullptr};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Touch::Touch() : maker_([this] { make_scenes(); }), watcher_([this] { watch(); }) {}

Touch::~Touch() {
  end();
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  wake_.notify_all();
  maker_.join();
  watcher_.join();
}

void Touch::begin(const LoadedScene& loaded, std::unique_ptr<Device> device, const std::filesystem::path& out) {
  end();
  options_ = RunOptions();
  options_.out = out;
  options_.primitives = true;
  options_.live.emplace();
  options_.arguments = {"explore"};
  prepared_ = PreparedRun();
  prepared_.loaded = loaded;
  prepared_.duration_s = std::numeric_limits<double>::infinity();
  if (!device) {
    auto pointer =
        std::make_unique<MouseHand>(MouseHand::Options{.radius_m = pointer_radius_m,
                                                       .largest_force_n = std::max(0.1, loaded.scene.coupling().max_force_n),
                                                       .largest_torque_nm = loaded.scene.coupling().max_torque_nm,
                                                       .turn = wanted_turn_});
    pointer_ = pointer.get();
    pointer_->put(wanted_m_);
    pointer_->have_mouse(has_mouse_);
    sent_m_ = wanted_m_;
    sent_turn_ = wanted_turn_;
    device = std::move(pointer);
  }
  device_ = std::move(device);
  prepared_.device = device_->name();
  run_ = std::make_unique<LiveRun>(options_, prepared_, *device_,
                                   [this](const TickFrame& frame, const Session& felt) { observe(frame, felt); });
  out_ = out;
  held_ = false;
  felt_now = run_.get();
}

std::string Touch::end() {
  if (!run_) return {};
  {
    const std::lock_guard lock(mutex_);  // protects `next_` from `make_scenes`
    next_.reset();
    felt_now = nullptr;
  }
  std::string lost = run_->finish();
  const std::lock_guard lock(mutex_);
  run_.reset();
  device_.reset();
  pointer_ = nullptr;
  out_.clear();
  return lost;
}

void Touch::change(const Scene& scene) {
  prepared_.loaded.scene = scene;
  {
    const std::lock_guard lock(mutex_);
    next_ = scene;
  }
  wake_.notify_all();
}

std::string Touch::take_problem() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problem_, {});
}

void Touch::make_scenes() {
  std::unique_lock lock(mutex_);
  while (!over_) {
    wake_.wait(lock, [this] { return over_ || next_; });
    if (over_ || !next_ || !run_) {
      next_.reset();
      continue;
    }
    const Scene scene = *std::exchange(next_, std::nullopt);
    try {
      run_->scene().set(scene);  // lock held: `end` waits for it
    } catch (const std::exception& error) {
      problem_ = error.what();
    }
  }
}

void Touch::put_hand(const Vec3& at_m) {
  wanted_m_ = sent_m_ = at_m;
  if (pointer_) pointer_->put(at_m);
}

void Touch::turn_hand(const Vec3& rotation_rad) { wanted_turn_ = turned_further(wanted_turn_, rotation_rad); }

void Touch::have_mouse(bool is_had) {
  has_mouse_ = is_had;
  if (pointer_) pointer_->have_mouse(is_had);
}

void Touch::beat(double dt_s) {
  last_beat_ns_ = now_ns();
  if (!run_) return;
  if (frozen_.exchange(false) && !held_) run_->loop().resume();
  if (!pointer_) return;
  const Vec3 step_m = shortened(wanted_m_ - sent_m_, led_m_per_s * std::clamp(dt_s, 0.0, 0.1));
  pointer_->move(step_m);
  sent_m_ += step_m;
  const Vec3 left_rad = rotation_between_rad(sent_turn_, wanted_turn_);
  const Vec3 turn_rad = shortened(left_rad, led_rad_per_s * std::clamp(dt_s, 0.0, 0.1));
  pointer_->turn(turn_rad);
  sent_turn_ = turned_further(sent_turn_, turn_rad);
}

void Touch::draws(bool on) {
  last_beat_ns_ = now_ns();
  drawing_ = on;
}

void Touch::watch() {
  std::unique_lock lock(mutex_);
  while (!over_) {
    wake_.wait_for(lock, std::chrono::milliseconds(50));
    LiveRun* const run = felt_now;
    if (!run || last_beat_ns_ == 0 || frozen_) continue;
    if (static_cast<double>(now_ns() - last_beat_ns_) < 1e9 * (drawing_ ? drawn_after_s : frozen_after_s)) continue;
    frozen_ = true;
    run->loop().panic();  // lock held: `end` waits for it
  }
}

void Touch::panic() {
  if (!run_) return;
  held_ = true;
  run_->loop().panic();
}

void Touch::resume() {
  if (!run_) return;
  held_ = false;
  run_->loop().resume();
}

void Touch::observe(const TickFrame& frame, const Session& session) noexcept {
  Sample sample{.frame = frame};
  const std::span<const ModeForce> modes = session.modes();
  sample.count = std::min(modes.size(), most_shown_modes);
  std::copy_n(modes.begin(), sample.count, sample.modes.begin());
  samples_.give(sample);
  if (observed_++ % ticks_per_moment != 0) return;
  Moment moment{.tick = frame.tick,
                .t_s = frame.t_s,
                .probe_m = frame.result.probe_m,
                .proxy_m = frame.result.proxy_m,
                .command_n = frame.command.force_n};
  std::span<const PlacedPrimitive> placed;
  if (!session.sub_steps().empty()) {
    const SubStep& last = session.sub_steps().back();
    placed = session.primitives().subspan(last.first_primitive, last.primitives);
  }
  moment.count = std::min(placed.size(), most_shown_primitives);
  std::copy_n(placed.begin(), moment.count, moment.primitives.begin());
  if (session.scene().tool().shape != ToolOptions::Shape::point)
    moment.take_tool(frame.result, frame.command.torque_nm, placed);
  moments_.give(moment);
}

}  // namespace palpa::explorer
