// Link with delay, jitter and loss on a simulated clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace palpa {

/// One way of a link.
struct LinkOptions {
  double delay_s = 0.0;  ///< >= 0
  double jitter_s =
      0.0;            ///< >= 0: each message takes up to this longer or shorter, evenly distributed, never less than no time
  double loss = 0.0;  ///< [1] [0, 1]: share of lost messages; on a reliable link they come once more, after a round trip
  bool reliable = false;  ///< in order, as TCP: a late or lost message holds up those behind it
  std::uint64_t seed = 1;
};

/// Parsed `delay_ms=20,jitter_ms=3,loss=0.01,reliable=1,seed=1`; `delay` and `jitter` are in ms as well. Throws LoadError with
/// the remedy.
LinkOptions link_options(const std::string& description);

/// Carries messages one way. Allocates; one thread.
class SimulatedLink {
 public:
  explicit SimulatedLink(const LinkOptions& options) : options_(options), random_(options.seed) {}
  /// \param now_s  [s] never decreasing
  void send(std::span<const std::byte> message, double now_s);
  /// Next message that has arrived, by time of arrival; empty: none. Valid until the next call.
  std::span<const std::byte> receive(double now_s);

 private:
  struct Message {
    double arrives_s;
    std::uint64_t number;
    std::vector<std::byte> bytes;
  };
  double random() noexcept;

  static constexpr double retry_s = 0.01;  // wait for an acknowledgement, beyond the round trip

  LinkOptions options_;
  std::uint64_t random_, sent_ = 0;
  double last_s_ = 0.0;  // arrival of the last message of a reliable link
  std::vector<Message> under_way_;
  std::vector<std::byte> received_;
};

}  // namespace palpa
