// Law of the systems without a proxy: force functions of the probe.
#pragma once

#include <optional>

#include "palpa/baseline/earlier_law.h"

namespace palpa::baseline {

/// The force is a function of the data at the probe and of the probe's velocity v. The data are sampled at the probe (`Steps`),
/// and the balance is probe + force/k, so that the coupling (Eq. 1, D = 0) renders that force exactly.
///
///   directed  s q: the vector or gradient as a force (Iwata & Noma 1993; Pao & Lawrence 1998)
///   point     −s v/|v| − c v: retarding force and viscosity (Avila & Sobierajski 1996; Iwata & Noma 1993)
///   line      likewise for the component of v across the line: transverse damping (Pao & Lawrence 1998)
///   plane     min(k·depth, s) q if the probe is behind it: a spring on the penetration, with a threshold
///             (Avila & Sobierajski 1996; Lawrence et al. 2000); its drag for the inward component of v
///
/// The formulas follow surveys and abstracts of these works; the paper itself has only the directed force. Points, lines and
/// planes were made for a proxy: their forces here are the least that these systems had for the purpose. v is the difference of
/// two probes over the time step; zero in the first.
///
/// Wrong in that nothing holds: friction ends when the hand stops; a surface yields under the least force and loses the point
/// of entry; a force whose direction changes over a short distance makes the hand vibrate.
class NoProxy final : public EarlierLaw {
 public:
  explicit NoProxy(std::size_t capacity = 64) : EarlierLaw(capacity) {}
  void reset() noexcept override;

 private:
  Moved move(const Posed& posed, std::span<Vec3> forces_n) noexcept override;

  struct Asked {
    Vec3 start_m;
    Vec3 probe_m;
    friend bool operator==(const Asked&, const Asked&) = default;
  };
  std::optional<Asked> last_;
  Vec3 probe_before_m_;
};

}  // namespace palpa::baseline
