// The data's side of a hand that is far: a session on the probes that arrive, and the local models of what it feels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "palpa/far/message.h"
#include "palpa/loop/loop.h"

namespace palpa {

/// Link and hand as the data's side measures them.
struct DataSideFacts {
  double round_trip_s = 0.0;  ///< mean of the last second; 0 before the first answer
  double lost = 0.0;          ///< [1] share of the samples that did not arrive in the last seconds
  std::int64_t samples = 0;   ///< ticks of the session
  std::int64_t models = 0;    ///< sent
  std::int64_t bytes = 0;     ///< of all messages given
  double ahead_s = 0.0;       ///< look-ahead of the last tick
  ProbeReport felt;           ///< last report of the hand
  TickFrame frame;            ///< last tick
};

/// Runs an ordinary session, a tick for each probe that arrives, and gives models of its last sub-step with what lies ahead of
/// the hand. Bytes in, bytes out: no socket, clock or thread. Allocates; one thread.
class DataSide {
 public:
  /// Throws SceneError for a scene without a far hand: a tool with an orientation, or another law than the exact one.
  explicit DataSide(const Scene& scene);
  ~DataSide();
  DataSide(DataSide&&) noexcept;
  DataSide& operator=(DataSide&&) noexcept;

  /// Ticks are offered to `recorder`, and reported to `observer` with the hand's report that brought their sample; before the
  /// hello. Either may be empty.
  using Observer = std::function<void(const TickFrame&, const Session&, const ProbeReport&)>;
  void record(Recorder* recorder, Observer observer);

  /// Takes a message of the hand, of any origin: a hello begins the session, within the limits of its device, a report ticks
  /// it. False if it is neither, damaged, or in the wrong order. May block on windows of a volume larger than memory. Throws
  /// SceneError for a hello alone, and the exceptions of the recorder's writer.
  /// \param now_s  [s] never decreasing, by a clock of the caller
  bool take(std::span<const std::byte> message, double now_s);
  /// Writes the next message for the hand; call until 0. Returns its length [bytes]; 0: none.
  /// \param to  at least `most_message_bytes`
  std::size_t give(std::span<std::byte> to, double now_s);

  /// Replaces the scene: welcomes the hand again, and continues at its proxy. Throws SceneError and changes nothing.
  void change(const Scene& scene);
  const DataSideFacts& facts() const noexcept;
  /// The scene as it is felt: with stiffness and damping within the limits of the hand's device.
  const Scene& scene() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
