#include "palpa/loop/live_scene.h"

#include <utility>

namespace palpa {

namespace {

Scene measured(Scene scene, std::vector<std::int64_t>& spent_ns) {
  for (std::size_t m = 0; m < spent_ns.size(); ++m)
    scene.edit_mode(scene.modes()[m].name, [&](SceneMode& mode) { mode.mode.measure(&spent_ns[m]); });
  return scene;
}

}  // namespace

PreparedSession::PreparedSession(const Scene& scene, double encoder_step_m)
    : spent_ns(scene.modes().size()),
      tool(scene.tool(), scene.coupling()),
      felt(scene, encoder_step_m),
      rehearsal(measured(scene, spent_ns), encoder_step_m) {}

LiveScene::State::State(const Scene& scene, const DeviceLimits& limits)
    : scene_(scene), limits_(limits), waiting_(prepared(scene).release()) {}

LiveScene::State::~State() {
  delete waiting_.load();
  free_given_back();
  delete loader_.load();
}

std::unique_ptr<PreparedSession> LiveScene::State::prepared(const Scene& scene) {
  const Scene clamped = clamped_to(scene, limits_);
  auto made = std::make_unique<PreparedSession>(clamped, limits_.encoder_step_m);
  const Stock& stock = made->felt.stock();
  if (stock.empty()) return made;
  if (!loader()) loader_.store(new WindowLoader, std::memory_order_release);
  made->loaded_scene = loader()->add(clamped, stock);
  return made;
}

Scene LiveScene::State::scene() const {
  const std::lock_guard lock(mutex_);
  return scene_;
}

void LiveScene::State::change(const std::function<void(Scene&)>& edit) {
  const std::lock_guard lock(mutex_);
  free_given_back();
  Scene changed = scene_;
  edit(changed);
  std::unique_ptr<PreparedSession> made = prepared(changed);
  scene_ = std::move(changed);
  delete waiting_.exchange(made.release(), std::memory_order_acq_rel);
}

void LiveScene::State::put_back(PreparedSession* session) noexcept {
  PreparedSession* none = nullptr;
  if (!waiting_.compare_exchange_strong(none, session, std::memory_order_acq_rel)) delete session;
}

void LiveScene::State::give_back(PreparedSession* session) noexcept {
  session->next = given_back_.load(std::memory_order_relaxed);
  while (!given_back_.compare_exchange_weak(session->next, session, std::memory_order_release, std::memory_order_relaxed)) {
  }
}

void LiveScene::State::free_given_back() noexcept {
  PreparedSession* session = given_back_.exchange(nullptr, std::memory_order_acquire);
  while (session) delete std::exchange(session, session->next);
}

LiveScene::LiveScene(const Scene& scene, const DeviceLimits& limits) : state_(std::make_unique<State>(scene, limits)) {}
LiveScene::~LiveScene() = default;

Scene LiveScene::scene() const { return state_->scene(); }
void LiveScene::set(const Scene& scene) {
  state_->change([&](Scene& changed) { changed = scene; });
}
void LiveScene::change(const std::function<void(Scene&)>& edit) { state_->change(edit); }

}  // namespace palpa
