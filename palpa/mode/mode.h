// Contract of a mode, and a type-erased mode.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpa/mode/mode_context.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// Write-only view of a sub-step's PrimitiveSet for a mode. Each function forwards to `PrimitiveSet`, which refuses unsolvable
/// input. Holds only a reference: pass by value.
class PrimitiveSink {
 public:
  PrimitiveSink(PrimitiveSet& set) noexcept : set_(set) {}  // NOLINT: implicit on purpose

  /// Holds the proxy at `position_m` in every direction.
  void point(std::uint16_t slot, const Vec3& position_m, double strength_n, double drag_ns_per_m = 0.0) const noexcept {
    set_.point(slot, position_m, strength_n, drag_ns_per_m);
  }
  /// Resists motion perpendicular to the unit vector `direction` [1].
  void line(std::uint16_t slot, const Vec3& position_m, const Vec3& direction, double strength_n,
            double drag_ns_per_m = 0.0) const noexcept {
    set_.line(slot, position_m, direction, strength_n, drag_ns_per_m);
  }
  /// Pushes along the unit vector `normal` [1] while the proxy is behind the plane.
  /// \param captured  level on which the plane lies: no sub-step crosses it
  void plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n, const HeldLevel& captured = {},
             double drag_ns_per_m = 0.0) const noexcept {
    set_.plane(slot, position_m, normal, strength_n, captured, drag_ns_per_m);
  }
  /// Elastic plane, deflected by its force divided by `stiffness_n_per_m`, > 0; `normal` [1].
  void elastic_plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                     double stiffness_n_per_m, const HeldLevel& captured = {}) const noexcept {
    set_.elastic_plane(slot, position_m, normal, strength_n, stiffness_n_per_m, captured);
  }
  /// Force of `strength_n` along the unit vector `direction` [1].
  void directed(std::uint16_t slot, const Vec3& direction, double strength_n) const noexcept {
    set_.directed(slot, direction, strength_n);
  }
  /// Friction line along the normal of the plane in slot `plane_slot`, placed after it, of strength `coefficient` [1] times the
  /// plane's force.
  void friction(std::uint16_t slot, std::uint16_t plane_slot, const Vec3& position_m, double coefficient,
                double drag_ns_per_m = 0.0) const noexcept {
    set_.friction(slot, plane_slot, position_m, coefficient, drag_ns_per_m);
  }

 private:
  PrimitiveSet& set_;
};

/// Crossing of a level or breakpoint by the proxy's path, located by the tick.
struct Crossing {
  std::int32_t field = -1;
  double value = 0.0;  ///< the field's own unit
  bool up = false;     ///< towards higher values
};

/// Result of an accepted sub-step, for a mode.
struct StepResult {
  const ModeContext& here;              ///< at the new proxy
  std::span<const Contact> contacts;    ///< of this mode, in the order placed
  std::span<const Crossing> crossings;  ///< of the whole session, in the order met

  /// Contact with a slot's primitive; nullptr without a primitive.
  const Contact* contact(std::uint16_t slot) const noexcept {
    for (const Contact& c : contacts) {
      if (c.id.slot == slot) return &c;
    }
    return nullptr;
  }
  /// State of a slot; off without a primitive.
  PrimitiveState state(std::uint16_t slot) const noexcept {
    const Contact* at = contact(slot);
    return at ? at->state : PrimitiveState::off;
  }
  /// Level of a slot's primitive; none without a primitive.
  HeldLevel captured(std::uint16_t slot) const noexcept {
    const Contact* at = contact(slot);
    return at ? at->level : HeldLevel{};
  }
  bool placed(std::uint16_t slot) const noexcept { return contact(slot) != nullptr; }
  /// Whether the plane of a slot yields: if it slips, its level moves to the proxy, without a break-through.
  bool yields(std::uint16_t slot) const noexcept {
    const Contact* at = contact(slot);
    return at && at->yields;
  }
};

/// A mode: a plain struct that reads fields at the proxy and places primitives.
///
///   static constexpr auto type = "lab.ridge";              its name in scene files
///   static constexpr auto summary = "…";                   what it feels like, one sentence (optional)
///   static constexpr auto parameters() { return std::tuple{param(…), …}; }
///   void place(const ModeContext&, PrimitiveSink) const noexcept;
///
/// `place` is pure: it may be called any number of times per sub-step, also at trial points. A mode with state declares a
/// trivially copyable `struct Memory` of at most 256 bytes; then
///   void place(const ModeContext&, const Memory&, PrimitiveSink) const noexcept;
///   void on_step_accepted(const StepResult&, Memory&) const noexcept;    once per accepted sub-step
/// A mode with constraints between parameters may add
///   std::string problem() const;                           empty, or the fault and its remedy
template <class M>
concept HasMemory = requires {
  typename M::Memory;
};

/// Type-erased mode; copies are deep.
class Mode {
 public:
  template <class M>
  requires(!std::is_same_v<std::remove_cvref_t<M>, Mode>) Mode(M mode)
      : model_(std::make_unique<Model<M>>(std::move(mode))),
        has_levels_(finds_levels(*model_)) {}  // NOLINT: implicit on purpose
  Mode(const Mode& other) : model_(other.model_->copy()), spent_ns_(other.spent_ns_), has_levels_(other.has_levels_) {}
  Mode(Mode&&) noexcept = default;
  Mode& operator=(const Mode& other) { return *this = Mode(other); }
  Mode& operator=(Mode&&) noexcept = default;

  std::string_view type() const { return model_->type(); }
  std::string_view summary() const { return model_->summary(); }
  std::string problem() const { return model_->problem(); }
  void visit(ParameterVisitor& visitor) { model_->visit(visitor); }
  /// Whether it stands on levels of its field: has parameters of that kind.
  bool has_levels() const noexcept { return has_levels_; }

  /// Bytes of memory kept by the session (0…256), and their initialisation.
  std::size_t memory_bytes() const noexcept { return model_->memory_bytes(); }
  void start(std::byte* memory) const noexcept { model_->start(memory); }
  void place(const ModeContext& here, const std::byte* memory, PrimitiveSink out) const noexcept {
    if (spent_ns_) {
      const auto begin = std::chrono::steady_clock::now();
      model_->place(here, memory, out);
      *spent_ns_ += std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
    } else {
      model_->place(here, memory, out);
    }
  }
  /// Adds the duration of each `place`, also of copies, to `*spent_ns`; nullptr: off.
  void measure(std::int64_t* spent_ns) noexcept { spent_ns_ = spent_ns; }
  void on_step_accepted(const StepResult& result, std::byte* memory) const noexcept {
    model_->on_step_accepted(result, memory);
  }

  /// The mode as its own type; nullptr for other types.
  template <class M>
  const M* as() const noexcept {
    const auto* model = dynamic_cast<const Model<M>*>(model_.get());
    return model ? &model->mode : nullptr;
  }
  template <class M>
  M* as() noexcept {
    auto* model = dynamic_cast<Model<M>*>(model_.get());
    return model ? &model->mode : nullptr;
  }

 private:
  struct Concept {
    virtual ~Concept() = default;
    virtual std::unique_ptr<Concept> copy() const = 0;
    virtual std::string_view type() const = 0;
    virtual std::string_view summary() const = 0;
    virtual std::string problem() const = 0;
    virtual void visit(ParameterVisitor& visitor) = 0;
    virtual std::size_t memory_bytes() const noexcept = 0;
    virtual void start(std::byte* memory) const noexcept = 0;
    virtual void place(const ModeContext& here, const std::byte* memory, PrimitiveSink out) const noexcept = 0;
    virtual void on_step_accepted(const StepResult& result, std::byte* memory) const noexcept = 0;
  };

  /// Whether `place` has a mode's signature; noexcept, since an exception within a tick would end the program.
  template <class M>
  static consteval bool places(const M* mode, const ModeContext* here, const PrimitiveSink* out) {
    if constexpr (HasMemory<M>) {
      return requires(const typename M::Memory& memory) { requires noexcept(mode->place(*here, memory, *out)); };
    } else {
      return requires { requires noexcept(mode->place(*here, *out)); };
    }
  }
  template <class M>
  static consteval bool is_listed(M* mode, ParameterVisitor* visitor) {
    return requires { M::parameters(); }
    || requires { visit_part(*mode, *visitor); };
  }

  template <class M>
  struct Model final : Concept {
    static_assert(is_listed<M>(nullptr, nullptr),
                  "a mode has `static constexpr auto parameters()`, the list of its keys; without any it returns std::tuple{}");
    static_assert(places<M>(nullptr, nullptr, nullptr),
                  "a mode has `void place(const ModeContext&, PrimitiveSink) const noexcept`, with `const Memory&` between the "
                  "two where it declares a struct Memory");

    explicit Model(M m) : mode(std::move(m)) {}
    std::unique_ptr<Concept> copy() const override { return std::make_unique<Model>(mode); }
    std::string_view type() const override { return M::type; }
    std::string_view summary() const override {
      if constexpr (requires { M::summary; }) return M::summary;
      return {};
    }
    std::string problem() const override {
      if constexpr (requires { mode.problem(); }) return mode.problem();
      return {};
    }
    void visit(ParameterVisitor& visitor) override { detail::visit_parameters(mode, visitor); }
    std::size_t memory_bytes() const noexcept override {
      if constexpr (HasMemory<M>) {
        static_assert(std::is_trivially_copyable_v<typename M::Memory>, "a mode's Memory must be trivially copyable");
        static_assert(sizeof(typename M::Memory) <= 256, "a mode's Memory must not exceed 256 bytes");
        return sizeof(typename M::Memory);
      }
      return 0;
    }
    void start(std::byte* memory) const noexcept override {
      if constexpr (HasMemory<M>) ::new (memory) typename M::Memory{};
    }
    void place(const ModeContext& here, const std::byte* memory, PrimitiveSink out) const noexcept override {
      if constexpr (HasMemory<M>) {
        mode.place(here, *std::launder(reinterpret_cast<const typename M::Memory*>(memory)), out);
      } else {
        mode.place(here, out);
      }
    }
    void on_step_accepted(const StepResult& result, std::byte* memory) const noexcept override {
      if constexpr (HasMemory<M>) mode.on_step_accepted(result, *std::launder(reinterpret_cast<typename M::Memory*>(memory)));
    }
    M mode;
  };

  static bool finds_levels(Concept& model);

  std::unique_ptr<Concept> model_;
  std::int64_t* spent_ns_ = nullptr;
  bool has_levels_ = false;
};

/// Mode types that scene files may name. Copyable.
class ModeCatalog {
 public:
  /// Adds the type of `example`, whose parameters become the defaults. Throws std::invalid_argument if the type exists.
  void add(Mode example);
  /// New mode of this type with its defaults; nullptr if unknown.
  const Mode* find(std::string_view type) const noexcept;
  const std::vector<Mode>& modes() const noexcept { return modes_; }

 private:
  std::vector<Mode> modes_;
};

const ModeCatalog& standard_modes();

}  // namespace palpa
