#include "explorer/touch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "explorer/hand_frame.h"
#include "palpa/data/octaves.h"

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

Touch::Touch() : maker_([this] { make_scenes(); }), watcher_([this] { watch(); }) { start(Scene(), 0.0); }

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

void Touch::start(const Scene& scene, double front_m) {
  end();
  led_ = 0;
  hands_.clear();
  for (std::size_t h = 0; h < std::max<std::size_t>(1, scene.hands().size()); ++h) {
    Hand& hand = *hands_.emplace_back(std::make_unique<Hand>());
    hand.origin_m = frame_origin_m(scene, h);
    hand.wanted_m = {hand.origin_m.x, hand.origin_m.y, front_m};
  }
}

std::unique_ptr<Device> Touch::new_pointer(Hand& hand, const CouplingOptions& coupling) const {
  auto pointer = std::make_unique<MouseHand>(MouseHand::Options{.radius_m = pointer_radius_m,
                                                                .largest_force_n = std::max(0.1, coupling.max_force_n),
                                                                .largest_torque_nm = coupling.max_torque_nm,
                                                                .turn = hand.wanted_turn});
  hand.pointer = pointer.get();
  pointer->put(hand.wanted_m - hand.origin_m);
  pointer->have_mouse(has_mouse_);
  hand.sent_m = hand.wanted_m;
  hand.sent_turn = hand.wanted_turn;
  return pointer;
}

void Touch::begin(const LoadedScene& loaded, std::unique_ptr<Device> device, const std::filesystem::path& out) {
  end();
  const std::vector<SceneHand>& all = loaded.scene.hands();
  std::vector<LiveRunHand> of_run;
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    Hand& hand = *hands_[h];
    hand.options = RunOptions();
    hand.options.out = all.size() > 1 && !out.empty() ? out / all[h].name : out;
    hand.options.primitives = true;
    hand.options.live.emplace();
    hand.options.arguments = {"explore"};
    if (!all.empty()) hand.options.scene_options.sets.emplace_back("only_hand", all[h].name);
    hand.prepared = PreparedRun();
    hand.prepared.loaded = loaded;
    hand.prepared.loaded.scene = loaded.scene.of_hand(h);
    hand.prepared.duration_s = std::numeric_limits<double>::infinity();
    hand.device = device ? std::move(device) : new_pointer(hand, loaded.scene.coupling());
    hand.prepared.device = hand.device->name();
    of_run.push_back({&hand.options, &hand.prepared, hand.device.get()});
  }
  std::error_code error;
  if (all.size() > 1 && !out.empty() && !std::filesystem::create_directory(out, error))
    throw LoadError(out.string() + ": the folder of the traces cannot be made; choose another, new one");
  run_ = std::make_unique<LiveRun>(
      of_run, [this](std::size_t hand, const TickFrame& frame, const Session& felt) { observe(hand, frame, felt); });
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
  for (const auto& hand : hands_) {
    hand->device.reset();
    hand->pointer = nullptr;
  }
  out_.clear();
  return lost;
}

void Touch::change(const Scene& scene) {
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
      for (std::size_t h = 0; h < hands_.size(); ++h) run_->set_scene(scene.of_hand(h), h);  // lock held: `end` waits for it
    } catch (const std::exception& error) {
      problem_ = error.what();
    }
  }
}

void Touch::lead(std::size_t hand) { led_ = hand; }

void Touch::put_hand(const Vec3& at_m) {
  Hand& hand = *hands_[led_];
  hand.wanted_m = hand.sent_m = at_m;
  if (hand.pointer) hand.pointer->put(at_m - hand.origin_m);
}

void Touch::turn_hand(const Vec3& rotation_rad) {
  Turn& turn = hands_[led_]->wanted_turn;
  turn = turned_further(turn, rotation_rad);
}

void Touch::have_mouse(bool is_had) {
  has_mouse_ = is_had;
  for (const auto& hand : hands_)
    if (hand->pointer) hand->pointer->have_mouse(is_had);
}

void Touch::turn_view(const Mat3& rotation) {
  for (std::size_t h = 0; run_ && h < hands_.size(); ++h)
    if (!hands_[h]->pointer) run_->loop().set_view_rotation(rotation, h);
}

void Touch::beat(double dt_s) {
  last_beat_ns_ = now_ns();
  if (!run_) return;
  if (frozen_.exchange(false) && !held_) run_->loop().resume();
  for (const auto& hand : hands_) {
    if (!hand->pointer) continue;
    const Vec3 step_m = shortened(hand->wanted_m - hand->sent_m, led_m_per_s * std::clamp(dt_s, 0.0, 0.1));
    hand->pointer->move(step_m);
    hand->sent_m += step_m;
    const Vec3 left_rad = rotation_between_rad(hand->sent_turn, hand->wanted_turn);
    const Vec3 turn_rad = shortened(left_rad, led_rad_per_s * std::clamp(dt_s, 0.0, 0.1));
    hand->pointer->turn(turn_rad);
    hand->sent_turn = turned_further(hand->sent_turn, turn_rad);
  }
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

/// The window of the felt octave of the first volume larger than memory, in hand metres.
static void take_window(const TickFrame& frame, const Session& session, Moment& moment) noexcept {
  if (session.stock().empty()) return;
  const auto octave = static_cast<int>(frame.result.felt_octave);
  const DataTime now = session.scene().time().at(frame.t_s);
  std::size_t first = session.stock().size();  // of a series the earliest frame that is sampled
  session.stock().for_each_sampled(now, [&](std::size_t n) { first = std::min(first, n); });
  const auto corners_m = session.stock().corners_m(first, octave, now);
  moment.has_window = corners_m.has_value();
  for (std::size_t corner = 0; corners_m && corner < 8; ++corner)
    moment.window_m[corner] = session.hand_to_world().to_hand((*corners_m)[corner]);
}

void Touch::observe(std::size_t number, const TickFrame& frame, const Session& session) noexcept {
  if (number == led_) {
    Sample sample{.frame = frame, .hand = number};
    const std::span<const ModeForce> modes = session.modes();
    sample.count = std::min(modes.size(), most_shown_modes);
    std::copy_n(modes.begin(), sample.count, sample.modes.begin());
    samples_.give(sample);
  }
  Hand& hand = *hands_[number];
  if (hand.observed++ % ticks_per_moment != 0) return;
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
  take_window(frame, session, moment);
  moment.shift(hand.origin_m);
  hand.moments.give(moment);
}

}  // namespace palpa::explorer
