// A mode made one order worse, to prove that a measure of order tells.
#pragma once

#include <algorithm>
#include <array>

#include "palpa/mode/mode.h"

namespace palpa::test {

/// A parameter of a mode as one of a mode that is derived from it.
template <class Derived, class M, class T, std::size_t N>
constexpr auto parameter_of(const Parameter<M, T, N>& p) {
  return Parameter<Derived, T, N>{p.name, p.member, p.sentence, p.kind, p.range, p.choices, p.felt};
}
template <class Derived, class M>
constexpr auto parameter_of(const Companion<M>& p) {
  return Companion<Derived>{p.member, p.of, p.felt, p.needed};
}

/// The mode M with its primitives' directions as they were where the proxy stood when the probe began its present step,
/// wherever the tick looks, so that its path is of order one.
template <class M>
struct PlacedAtStart : M {
  struct Nothing {};
  template <class T>
  struct MemoryOf {
    using type = Nothing;
  };
  template <HasMemory T>
  struct MemoryOf<T> {
    using type = typename T::Memory;
  };
  struct Directions {
    std::array<Vec3, 2> of{};
    std::size_t count = 0;
  };
  struct Memory {
    typename MemoryOf<M>::type own{};
    Vec3 probe_m{};         // at the last sub-step
    Directions at_start{};  // of the probe's step that ended there
    Directions latest{};
  };

  static constexpr auto parameters() {
    return std::apply([](const auto&... p) { return std::tuple{parameter_of<PlacedAtStart>(p)...}; }, M::parameters());
  }
  void place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept {
    const std::size_t first = out.size();
    place_own(here, memory, out);
    const Directions& kept = here.probe_m == memory.probe_m ? memory.at_start : memory.latest;
    for (std::size_t i = 0; i < std::min(kept.count, out.size() - first); ++i) {
      Primitive turned = out[first + i];
      turned.direction = kept.of[i];
      out.replace(first + i, turned, out.captured(first + i));
    }
  }

  void settle(const Settled& settled, Memory& memory) const noexcept {
    if constexpr (HasMemory<M>) M::settle(settled, memory.own);
    if (settled.here.probe_m != memory.probe_m) memory.at_start = memory.latest;
    memory.probe_m = settled.here.probe_m;
    PrimitiveSet placed(8);
    placed.clear(settled.here.proxy_m);
    place_own(settled.here, memory, placed);
    memory.latest.count = std::min(placed.size(), memory.latest.of.size());
    for (std::size_t i = 0; i < memory.latest.count; ++i) memory.latest.of[i] = placed[i].direction;
  }

 private:
  void place_own(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept {
    if constexpr (HasMemory<M>) {
      M::place(here, memory.own, out);
    } else {
      M::place(here, out);
    }
  }
};

}  // namespace palpa::test
