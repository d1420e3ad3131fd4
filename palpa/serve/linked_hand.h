// A hand and its data on both ends of a simulated link, on one clock.
#pragma once

#include <array>

#include "palpa/far/hand_side.h"
#include "palpa/serve/data_side.h"
#include "palpa/serve/simulated_link.h"

namespace palpa {

/// Both sides with a link between. Allocates; one thread.
class LinkedHand {
 public:
  /// Throws SceneError as DataSide does. \param link  of both ways
  LinkedHand(const Scene& scene, const LinkOptions& link, const HandSideOptions& options = {.motors = false})
      : hand(options), data(scene), there_(link), back_(other_way(link)) {}

  /// A tick: the sample, messages to the data and back as far as the link lets them, the command.
  HandTick tick(const HandSample& sample, double time_step_s = 1e-3, std::uint32_t circumstances = 0) {
    now_s += time_step_s;
    hand.begin(sample, time_step_s);
    std::array<std::byte, most_message_bytes> room;
    while (const std::size_t bytes = hand.give(room)) {
      if (is_up) there_.send({room.data(), bytes}, now_s);
    }
    for (auto message = there_.receive(now_s); !message.empty(); message = there_.receive(now_s)) {
      data.take(message, now_s);
      answer(room);
    }
    answer(room);
    for (auto message = back_.receive(now_s); !message.empty(); message = back_.receive(now_s))
      if (is_up) hand.take(message);
    return hand.feel(circumstances);
  }

  HandSide hand;
  DataSide data;
  double now_s = 0.0;
  bool is_up = true;  ///< messages pass

 private:
  static LinkOptions other_way(LinkOptions link) {
    link.seed += 1000;
    return link;
  }
  void answer(std::span<std::byte> room) {
    while (const std::size_t bytes = data.give(room, now_s)) {
      if (is_up) back_.send(room.first(bytes), now_s);
    }
  }
  SimulatedLink there_, back_;
};

}  // namespace palpa
