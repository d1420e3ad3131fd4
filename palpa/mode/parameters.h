// Parameters: the one list of a mode's keys, from which scene files, error messages, `palpa modes`
// and the documentation are made.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "palpa/grid/derived.h"

namespace palpa {

/// A field of a scene by name: `volume` (its only field), `volume.field`, or `FUNC(FIELD)`. `index` is filled in when a
/// session resolves the name.
struct FieldRef {
  std::string name;
  std::int32_t index = -1;
  friend bool operator==(const FieldRef& a, const FieldRef& b) { return a.name == b.name; }
};

/// A transfer function, of a field's value, for strengths and masks. Piecewise linear in the value; beyond the points it is
/// `outside`. Two points with equal value are a step. The end points belong to the function: at the first and at the last value
/// the result is theirs, whatever the side.
///
/// Evaluation never allocates or throws, and is finite for every value.
class TransferFunction {
 public:
  struct Point {
    double value = 0.0;   ///< of the field, in the field's own unit
    double result = 0.0;  ///< [N] of a strength, [1] 0…1 of a mask
    friend bool operator==(const Point&, const Point&) = default;
  };
  /// Which of the two results a step has at its own value.
  enum class Side { below, above };

  TransferFunction() = default;
  /// \param points   with values that do not fall; at least one, at most two of one value
  /// \param outside  [N] or [1] as the results; holds below the first and above the last value
  /// Throws std::invalid_argument, with a sentence, on points that fall, are not finite or beyond 1e300.
  TransferFunction(std::vector<Point> points, double outside = 0.0);

  /// The result [N] or [1] at `value`, in the field's own unit. At a step, the limit from `side`. 0 for an empty function or a
  /// NaN.
  double at(double value, Side side = Side::above) const noexcept;
  /// dresult/dvalue [N/unit] at `value`, in the field's own unit; at a point that of the piece on `side`; 0 beyond the points,
  /// for an empty function or a NaN.
  double slope_at(double value, Side side = Side::above) const noexcept;
  /// Whether it is zero at `value`, in the field's own unit, and on both sides of it, up to the points next to it. At the first
  /// and the last point what is beyond does not count.
  bool stays_zero_at(double value) const noexcept;

  const std::vector<Point>& points() const noexcept { return points_; }
  double outside() const noexcept { return outside_; }  ///< [N] or [1] as the results
  friend bool operator==(const TransferFunction&, const TransferFunction&) = default;

 private:
  std::vector<Point> points_;
  double outside_ = 0.0;
};

/// Newtons: a number, or a function of any field of any volume.
struct Strength {
  double constant_n = 0.0;
  FieldRef of;  ///< set: the strength is `curve` of this field's value, and constant_n is unused
  TransferFunction curve;

  Strength() = default;
  Strength(double newtons) : constant_n(newtons) {}  // NOLINT: a number is a strength
  Strength(FieldRef field, TransferFunction function) : of(std::move(field)), curve(std::move(function)) {}
  bool is_constant() const noexcept { return of.name.empty(); }
  friend bool operator==(const Strength&, const Strength&) = default;
};

/// A factor 0…1 on all strengths of a mode.
struct Mask {
  FieldRef of;
  TransferFunction curve;
  friend bool operator==(const Mask&, const Mask&) = default;
};

/// What a number may be, in the unit of its name.
struct Range {
  double low = 0.0;   ///< the parameter's own unit
  double high = 0.0;  ///< the parameter's own unit
};

enum class ParameterKind : std::uint8_t {
  number,
  optional_number,
  flag,
  text,
  choice,
  scalar_field,
  vector_field,
  optional_field,
  strength,
  level,
  vector,
  list
};

/// What a parameter is called, in which unit (the suffix of its name), what it means, what it may be.
struct ParameterInfo {
  std::string_view name;
  std::string_view sentence;
  ParameterKind kind = ParameterKind::number;
  Range range;                                ///< of numbers and strengths
  std::span<const std::string_view> choices;  ///< of a choice
  std::optional<Derivation> felt{};           ///< of a field: the mode feels this derivation of it
  /// A field or a level has no default: a scene must give it.
  bool required() const noexcept {
    return kind == ParameterKind::scalar_field || kind == ParameterKind::vector_field || kind == ParameterKind::level;
  }
};

class ParameterVisitor;

/// A list of structs with parameters of their own (levels).
class ParameterList {
 public:
  virtual ~ParameterList() = default;
  virtual std::size_t size() const = 0;
  virtual void append() = 0;  ///< one more, with its defaults
  virtual void visit(std::size_t i, ParameterVisitor& visitor) = 0;
  virtual void visit_default(ParameterVisitor& visitor) = 0;  ///< the parameters of a fresh one
};

/// Sees, and may change, every parameter of a mode in the order of its list.
class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;
  virtual void number(const ParameterInfo&, double&) {}  ///< also a level
  virtual void optional_number(const ParameterInfo&, std::optional<double>&) {}
  virtual void flag(const ParameterInfo&, bool&) {}
  virtual void text(const ParameterInfo&, std::string&) {}
  virtual void choice(const ParameterInfo&, int&) {}  ///< index in info.choices
  virtual void field(const ParameterInfo&, FieldRef&) {}
  virtual void strength(const ParameterInfo&, Strength&) {}
  virtual void vector(const ParameterInfo&, Vec3&) {}  ///< along the axes of the world
  virtual void list(const ParameterInfo&, ParameterList&) {}
  /// No key of its own: `ref` is `felt` of the field that another parameter names. Seen only where the mode needs it.
  virtual void companion(FieldRef& /*ref*/, const FieldRef& /*of*/, Derivation /*felt*/) {}
};

/// One entry of a mode's `parameters()`. Made by the functions below, never by hand.
template <class Owner, class T, std::size_t Choices = 0>
struct Parameter {
  std::string_view name;
  T Owner::*member;
  std::string_view sentence;
  ParameterKind kind;
  Range range;
  std::array<std::string_view, Choices> choices{};
  std::optional<Derivation> felt{};
};

/// A number; its unit is the suffix of its name.
template <class O>
constexpr auto param(std::string_view name, double O::*member, std::string_view sentence, Range range) {
  return Parameter<O, double>{name, member, sentence, ParameterKind::number, range, {}};
}
/// A number that may be left out, which then means something of its own (the sentence says what).
template <class O>
constexpr auto param(std::string_view name, std::optional<double> O::*member, std::string_view sentence, Range range) {
  return Parameter<O, std::optional<double>>{name, member, sentence, ParameterKind::optional_number, range, {}};
}
template <class O>
constexpr auto param(std::string_view name, bool O::*member, std::string_view sentence) {
  return Parameter<O, bool>{name, member, sentence, ParameterKind::flag, {}, {}};
}
template <class O>
constexpr auto param(std::string_view name, std::string O::*member, std::string_view sentence) {
  return Parameter<O, std::string>{name, member, sentence, ParameterKind::text, {}, {}};
}
/// A strength in newtons; the range holds for the number and for every result of the function.
template <class O>
constexpr auto param(std::string_view name, Strength O::*member, std::string_view sentence, Range range = {0.0, 1000.0}) {
  return Parameter<O, Strength>{name, member, sentence, ParameterKind::strength, range, {}};
}
/// A scalar field.
template <class O>
constexpr auto param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{name, member, sentence, ParameterKind::scalar_field, {}, {}};
}
/// A vector field.
template <class O>
constexpr auto vector_param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{name, member, sentence, ParameterKind::vector_field, {}, {}};
}
/// A field of which the mode feels a derivation: `here.scalar(field)` is that of the derived field.
template <class O>
constexpr auto derived_param(std::string_view name, FieldRef O::*member, Derivation felt, std::string_view sentence) {
  const bool of_scalar = felt == Derivation::smooth || felt == Derivation::gradient_magnitude;
  const ParameterKind kind = of_scalar ? ParameterKind::scalar_field : ParameterKind::vector_field;
  return Parameter<O, FieldRef>{name, member, sentence, kind, {}, {}, felt};
}
/// A second derivation of a field that another parameter names, filled in where `needed` says so.
template <class Owner>
struct Companion {
  FieldRef Owner::*member;
  FieldRef Owner::*of;
  Derivation felt;
  bool (Owner::*needed)() const;
};
template <class O>
constexpr auto companion_param(FieldRef O::*member, FieldRef O::*of, Derivation felt, bool (O::*needed)() const) {
  return Companion<O>{member, of, felt, needed};
}
/// A field of either kind that may be left out.
template <class O>
constexpr auto optional_field_param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{name, member, sentence, ParameterKind::optional_field, {}, {}};
}
/// A value of the mode's parameter `field` that is felt as a surface: the tick finds it along the path.
template <class O>
constexpr auto level_param(std::string_view name, double O::*member, std::string_view sentence) {
  return Parameter<O, double>{name, member, sentence, ParameterKind::level, {}, {}};
}
/// A vector along the axes of the world, in the unit of the mode's parameter `field`: [0, 0, 0] by default.
template <class O>
constexpr auto param(std::string_view name, Vec3 O::*member, std::string_view sentence) {
  return Parameter<O, Vec3>{name, member, sentence, ParameterKind::vector, {}, {}};
}
/// One of several words, stored as an enum whose values are 0, 1, 2, … in the order of the words.
template <class O, class Enum, class... Words>
requires std::is_enum_v<Enum>
constexpr auto choice_param(std::string_view name, Enum O::*member, std::string_view sentence, Words... words) {
  return Parameter<O, Enum, sizeof...(Words)>{name, member, sentence, ParameterKind::choice, {}, {std::string_view(words)...}};
}
/// A list of structs that have a `parameters()` of their own.
template <class O, class Item>
constexpr auto list_param(std::string_view name, std::vector<Item> O::*member, std::string_view sentence) {
  return Parameter<O, std::vector<Item>>{name, member, sentence, ParameterKind::list, {}, {}};
}

namespace detail {

template <class T>
void visit_parameters(T& owner, ParameterVisitor& visitor);

template <class Item>
class ListOf final : public ParameterList {
 public:
  explicit ListOf(std::vector<Item>& items) : items_(items) {}
  std::size_t size() const override { return items_.size(); }
  void append() override { items_.emplace_back(); }
  void visit(std::size_t i, ParameterVisitor& visitor) override { visit_parameters(items_[i], visitor); }
  void visit_default(ParameterVisitor& visitor) override {
    Item item;
    visit_parameters(item, visitor);
  }

 private:
  std::vector<Item>& items_;
};

template <class O, class T, std::size_t N>
void visit_parameter(O& owner, const Parameter<O, T, N>& p, ParameterVisitor& visitor) {
  const ParameterInfo info{p.name, p.sentence, p.kind, p.range, p.choices, p.felt};
  T& value = owner.*(p.member);
  if constexpr (std::is_same_v<T, double>) {
    visitor.number(info, value);
  } else if constexpr (std::is_same_v<T, std::optional<double>>) {
    visitor.optional_number(info, value);
  } else if constexpr (std::is_same_v<T, bool>) {
    visitor.flag(info, value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    visitor.text(info, value);
  } else if constexpr (std::is_same_v<T, FieldRef>) {
    visitor.field(info, value);
  } else if constexpr (std::is_same_v<T, Vec3>) {
    visitor.vector(info, value);
  } else if constexpr (std::is_same_v<T, Strength>) {
    visitor.strength(info, value);
  } else if constexpr (std::is_enum_v<T>) {
    int index = static_cast<int>(value);
    visitor.choice(info, index);
    value = static_cast<T>(index);
  } else {
    ListOf<typename T::value_type> list(value);
    visitor.list(info, list);
  }
}

template <class O>
void visit_parameter(O& owner, const Companion<O>& companion, ParameterVisitor& visitor) {
  if ((owner.*(companion.needed))()) visitor.companion(owner.*(companion.member), owner.*(companion.of), companion.felt);
}

template <class T>
void visit_parameters(T& owner, ParameterVisitor& visitor) {
  const auto parameters = T::parameters();
  std::apply([&](const auto&... p) { (visit_parameter(owner, p, visitor), ...); }, parameters);
}

}  // namespace detail

}  // namespace palpa
