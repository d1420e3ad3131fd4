// View of a live run, or of far hands, for 3D Slicer and other clients of OpenIGTLink.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "devices/igtl_messages.h"
#include "palpa/device/latest.h"
#include "palpa/loop/loop.h"

namespace palpa::app {

/// A hand's tick for a view. Trivially copyable.
struct IgtlHandView {
  bool is_known = false;
  bool has_probe = false;
  Similarity hand_to_world;
  Vec3 probe_m, proxy_m;  ///< [m] hand frame
  Turn probe_turn, proxy_turn;
  GuardState guard = GuardState::waiting;
  GuardCause cause = GuardCause::start;
};

/// An event of a hand. Trivially copyable.
struct IgtlEvent {
  SessionEvent event;
  double t_s = 0.0;
  std::array<char, 40> mode{};  ///< its name, ends at the first zero, or after all
};

/// Server of OpenIGTLink on 127.0.0.1, on a thread of its own: TRANSFORM of probe and proxy at 30 Hz, STRING for each event,
/// STATUS when the guard's state changes, IMAGE on request (docs/slicer.md). At most 8 clients; one that reads nothing for
/// two seconds is let go. The loop neither blocks on it nor allocates for it.
class IgtlView {
 public:
  static constexpr std::size_t most_hands = 8;  ///< [1] as a scene has

  /// Throws LoadError if the port cannot be had.
  /// \param port  0: any that is free
  explicit IgtlView(std::uint16_t port);
  ~IgtlView();  ///< blocks for 50 ms at most, and while a slice of an image is sampled
  IgtlView(const IgtlView&) = delete;
  IgtlView& operator=(const IgtlView&) = delete;
  std::uint16_t port() const noexcept { return port_; }

  /// After each tick of a hand, on one thread for each hand at a time, as a loop's. Neither allocates nor blocks.
  void tick(std::size_t hand, const TickFrame& frame, const Session& felt) noexcept;
  /// Likewise, when a hand has gone.
  void leave(std::size_t hand) noexcept;
  /// Some ten times a second, on a thread that may block: calls `scene()` if an image of it is requested.
  template <class SceneNow>
  void watch(SceneNow&& scene) {
    if (wants_scene_.exchange(false)) give(scene());
  }

 private:
  class Server;
  friend class Server;
  static constexpr std::size_t most_events = 64;  // between two looks. More: memory; fewer: events of a burst are lost

  struct Hand {
    void note(const SessionEvent& event, double t_s, const Scene& scene) noexcept;
    bool take(IgtlEvent& event) noexcept;

    Latest<IgtlHandView> view;
    std::array<IgtlEvent, most_events> events;
    std::atomic<std::size_t> written{0}, read{0};  // [1] events
  };

  void give(const Scene& scene);

  std::array<Hand, most_hands> hands_;
  std::atomic<bool> wants_scene_{false}, ends_{false};
  std::mutex mutex_;  // of `scene_`; the loop never takes it
  std::shared_ptr<const Scene> scene_;
  int socket_ = -1;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace palpa::app
