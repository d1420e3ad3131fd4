// Parameters: one list of a mode's keys for scene files, error messages, `palpa modes` and the documentation. The other parts
// of a scene have lists of this kind (scene/parts.h).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpa/data/derived.h"

namespace palpa {

class FieldRef;

namespace detail {
/// Numbers of a field and of its companion (`companion_param`) in a session; -1: none.
struct FieldNumbers {
  std::int32_t field = -1;
  std::int32_t companion = -1;
};
/// Numbers that a reference is resolved to. For the runtime, in its own copies of modes.
FieldNumbers& field_numbers(FieldRef& ref) noexcept;
const FieldNumbers& field_numbers(const FieldRef& ref) noexcept;
}  // namespace detail

/// A field of a scene by name: `volume` (its only field), `volume.field`, or `FUNC(FIELD)`. A session resolves the references
/// in its own copies of the modes; a mode reads data through them by its ModeContext.
class FieldRef {
 public:
  FieldRef() = default;
  FieldRef(std::string field) : name(std::move(field)) {}  // NOLINT: implicit on purpose

  std::string name;
  friend bool operator==(const FieldRef& a, const FieldRef& b) { return a.name == b.name; }

 private:
  friend detail::FieldNumbers& detail::field_numbers(FieldRef& ref) noexcept;
  friend const detail::FieldNumbers& detail::field_numbers(const FieldRef& ref) noexcept;
  detail::FieldNumbers numbers_;
};

inline detail::FieldNumbers& detail::field_numbers(FieldRef& ref) noexcept { return ref.numbers_; }
inline const detail::FieldNumbers& detail::field_numbers(const FieldRef& ref) noexcept { return ref.numbers_; }

/// Transfer function of a field's value, for strengths and masks. Piecewise linear; `outside` beyond the points. Two points
/// with equal value are a step. At the first and at the last value the result is that of the end point, on either side.
///
/// Evaluation never allocates or throws, and is finite for every value.
class TransferFunction {
 public:
  struct Point {
    double value = 0.0;   ///< of the field, in the field's own unit
    double result = 0.0;  ///< [N] of a strength, [1] 0…1 of a mask
    friend bool operator==(const Point&, const Point&) = default;
  };
  /// Side of a step whose result holds at its value.
  enum class Side { below, above };

  TransferFunction() = default;
  /// \param points   at least one; values must not decrease, at most two may be equal
  /// \param outside  [N] or [1] as the results; holds below the first and above the last value
  /// Throws std::invalid_argument, with a sentence, on values that decrease, are not finite or beyond 1e300.
  TransferFunction(std::vector<Point> points, double outside = 0.0);

  /// Result [N] or [1] at `value`, in the field's own unit. At a step, the limit from `side`. 0 for an empty function or a NaN.
  double at(double value, Side side = Side::above) const noexcept;
  /// dresult/dvalue [N/unit] at `value`, in the field's own unit; at a point on its `side`; 0 beyond the points, for an empty
  /// function or a NaN.
  double slope_at(double value, Side side = Side::above) const noexcept;
  /// Whether it is zero at `value`, in the field's own unit, and up to the adjacent points on both sides. The outside does not
  /// count.
  bool stays_zero_at(double value) const noexcept;

  const std::vector<Point>& points() const noexcept { return points_; }
  double outside() const noexcept { return outside_; }  ///< [N] or [1] as the results
  friend bool operator==(const TransferFunction&, const TransferFunction&) = default;

 private:
  std::vector<Point> points_;
  double outside_ = 0.0;
};

/// Strength in newtons: a number, or a function of any field of any volume.
struct Strength {
  double constant_n = 0.0;
  FieldRef of;  ///< set: the strength is `curve` of this field's value, and constant_n is unused
  TransferFunction curve;

  Strength() = default;
  Strength(double newtons) : constant_n(newtons) {}  // NOLINT: implicit on purpose
  Strength(FieldRef field, TransferFunction function) : of(std::move(field)), curve(std::move(function)) {}
  bool is_constant() const noexcept { return of.name.empty(); }
  friend bool operator==(const Strength&, const Strength&) = default;
};

/// Factor 0…1 on all strengths of a mode.
struct Mask {
  FieldRef of;
  TransferFunction curve;
  friend bool operator==(const Mask&, const Mask&) = default;
};

/// Range of a number, in the unit of its name: [low, high], or (low, high]; unbounded by default. Never contains NaN.
struct Range {
  double low = -std::numeric_limits<double>::infinity();  ///< the parameter's own unit
  double high = std::numeric_limits<double>::infinity();  ///< the parameter's own unit
  bool above_low = false;                                 ///< excludes `low` itself
  /// \param value  the parameter's own unit
  constexpr bool contains(double value) const noexcept { return (above_low ? value > low : value >= low) && value <= high; }
};

enum class ParameterKind : std::uint8_t {
  number,
  optional_number,
  whole_number,
  flag,
  text,  ///< limited to the choices, if there are any
  texts,
  choice,
  volume,  ///< name of a volume
  scalar_field,
  vector_field,
  optional_field,
  strength,
  level,
  vector,         ///< of the world: 3 numbers
  vectors,        ///< list of vectors
  numbers,        ///< list of finite numbers
  whole_numbers,  ///< list, each within the range
  list,           ///< tables with parameters of their own
  table,          ///< single table
  named_tables,   ///< table of tables, keyed by their `name`, a plain word
  rows,           ///< list of lists
};

/// Description of a parameter: name with unit suffix, meaning, range.
struct ParameterInfo {
  std::string_view name;
  std::string_view sentence;
  ParameterKind kind = ParameterKind::number;
  Range range{};                                ///< of numbers and strengths
  std::span<const std::string_view> choices{};  ///< of a choice or a text; of an optional number, the word for none
  std::size_t count = 0;                        ///< length of a list of numbers
  std::optional<Derivation> felt{};             ///< of a field: the derivation that the mode samples
  std::string_view form{};                      ///< format of its value, for people; empty: by its kind
  std::optional<std::string_view> fallback{};   ///< value if left out, for people; none: the default itself
  bool needed = false;                          ///< must be given
  /// A field or a level has no default.
  bool required() const noexcept {
    return needed || kind == ParameterKind::scalar_field || kind == ParameterKind::vector_field || kind == ParameterKind::level;
  }
};

class ParameterVisitor;

/// List of structs with parameters of their own (levels), or a single struct.
class ParameterList {
 public:
  virtual ~ParameterList() = default;
  virtual std::size_t size() const = 0;
  virtual void append() = 0;  ///< adds an item with its defaults
  virtual void visit(std::size_t i, ParameterVisitor& visitor) = 0;
  virtual void visit_default(ParameterVisitor& visitor) = 0;  ///< of a new item
};

/// Visits, and may change, every parameter of a mode in the order of its list.
class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;
  virtual void number(const ParameterInfo&, double&) {}  ///< also a level
  virtual void optional_number(const ParameterInfo&, std::optional<double>&) {}
  virtual void flag(const ParameterInfo&, bool&) {}
  virtual void text(const ParameterInfo&, std::string&) {}  ///< also the name of a volume
  virtual void choice(const ParameterInfo&, int&) {}        ///< index in info.choices; -1: none
  virtual void field(const ParameterInfo&, FieldRef&) {}
  virtual void strength(const ParameterInfo&, Strength&) {}
  virtual void list(const ParameterInfo&, ParameterList&) {}  ///< also a table, and named tables
  virtual void whole_number(const ParameterInfo&, std::optional<std::int64_t>&) {}
  virtual void numbers(const ParameterInfo&, std::vector<double>&) {}  ///< info.count of them, or none
  virtual void texts(const ParameterInfo&, std::vector<std::string>&) {}
  virtual void vectors(const ParameterInfo&, std::vector<Vec3>&) {}
  virtual void other(const ParameterInfo&) {}  ///< handled by the reader and writer of the struct
  /// Without a key: the derivation `felt` of another parameter's field. Visited only if the mode needs it.
  virtual void companion(FieldRef& /*of*/, Derivation /*felt*/) {}
};

/// Entry of a mode's `parameters()`. Made by the functions below.
template <class Owner, class T, std::size_t Choices = 0>
struct Parameter {
  T Owner::*member;
  ParameterInfo info;
  std::array<std::string_view, Choices> choices{};

  /// With the format shown to people: "[x, y, z]".
  constexpr Parameter written(std::string_view form) const {
    Parameter same = *this;
    same.info.form = form;
    return same;
  }
  /// With the meaning of a left-out value, for people; "": none.
  constexpr Parameter left_out(std::string_view meaning) const {
    Parameter same = *this;
    same.info.fallback = meaning;
    return same;
  }
  constexpr Parameter needed() const {
    Parameter same = *this;
    same.info.needed = true;
    return same;
  }
};

/// Number; its unit is the suffix of its name.
template <class O>
constexpr auto param(std::string_view name, double O::*member, std::string_view sentence, Range range) {
  return Parameter<O, double>{member, {name, sentence, ParameterKind::number, range}};
}
/// Optional number; the sentence explains its absence.
template <class O>
constexpr auto param(std::string_view name, std::optional<double> O::*member, std::string_view sentence, Range range,
                     std::span<const std::string_view> word_for_none = {}) {
  return Parameter<O, std::optional<double>>{member, {name, sentence, ParameterKind::optional_number, range, word_for_none}};
}
/// Whole number. A value out of its range stands for none.
template <class O, class T>
requires((std::is_integral_v<T> && !std::is_same_v<T, bool>) ||
         std::is_same_v<T, std::optional<int>>) constexpr auto param(std::string_view name, T O::*member,
                                                                     std::string_view sentence, Range range) {
  return Parameter<O, T>{member, {name, sentence, ParameterKind::whole_number, range}};
}
template <class O>
constexpr auto param(std::string_view name, bool O::*member, std::string_view sentence) {
  return Parameter<O, bool>{member, {name, sentence, ParameterKind::flag}};
}
/// Text, limited to the choices if there are any. They must outlive every use.
template <class O>
constexpr auto param(std::string_view name, std::string O::*member, std::string_view sentence,
                     std::span<const std::string_view> choices = {}) {
  return Parameter<O, std::string>{member, {name, sentence, ParameterKind::text, {}, choices}};
}
template <class O>
constexpr auto param(std::string_view name, std::vector<std::string> O::*member, std::string_view sentence) {
  return Parameter<O, std::vector<std::string>>{member, {name, sentence, ParameterKind::texts}};
}
template <class O>
constexpr auto volume_param(std::string_view name, std::string O::*member, std::string_view sentence) {
  return Parameter<O, std::string>{member, {name, sentence, ParameterKind::volume}};
}
/// Strength in newtons; the range holds for the number and for every result of the function.
template <class O>
constexpr auto param(std::string_view name, Strength O::*member, std::string_view sentence, Range range = {0.0, 1000.0}) {
  return Parameter<O, Strength>{member, {name, sentence, ParameterKind::strength, range}};
}
template <class O>
constexpr auto param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{member, {name, sentence, ParameterKind::scalar_field}};
}
template <class O>
constexpr auto vector_param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{member, {name, sentence, ParameterKind::vector_field}};
}
/// Field that the mode samples through a derivation: `here.scalar(field)` is the derived field's.
template <class O>
constexpr auto derived_param(std::string_view name, FieldRef O::*member, Derivation felt, std::string_view sentence) {
  const bool of_scalar = felt == Derivation::smooth || felt == Derivation::gradient_magnitude;
  const ParameterKind kind = of_scalar ? ParameterKind::scalar_field : ParameterKind::vector_field;
  return Parameter<O, FieldRef>{member, {.name = name, .sentence = sentence, .kind = kind, .felt = felt}};
}
/// Second derivation of another parameter's field, its companion, resolved if `needed` returns true:
/// `here.companion_scalar(field)`.
template <class Owner>
struct Companion {
  FieldRef Owner::*of;
  Derivation felt;
  bool (Owner::*needed)() const;
};
template <class O>
constexpr auto companion_param(FieldRef O::*of, Derivation felt, bool (O::*needed)() const) {
  return Companion<O>{of, felt, needed};
}
template <class O>
constexpr auto optional_field_param(std::string_view name, FieldRef O::*member, std::string_view sentence) {
  return Parameter<O, FieldRef>{member, {name, sentence, ParameterKind::optional_field}};
}
/// Value of the mode's parameter `field` that is felt as a surface: the tick finds it along the path.
template <class O>
constexpr auto level_param(std::string_view name, double O::*member, std::string_view sentence) {
  return Parameter<O, double>{member, {name, sentence, ParameterKind::level}};
}
/// Vector along the axes of the world, in the unit of the mode's parameter `field`: [0, 0, 0] by default.
template <class O>
constexpr auto param(std::string_view name, Vec3 O::*member, std::string_view sentence) {
  return Parameter<O, Vec3>{
      member, {.name = name, .sentence = sentence, .kind = ParameterKind::vector, .count = 3, .form = "[x, y, z]"}};
}
/// Optional vector along the axes of the world.
template <class O>
constexpr auto param(std::string_view name, std::optional<Vec3> O::*member, std::string_view sentence) {
  return Parameter<O, std::optional<Vec3>>{
      member, {.name = name, .sentence = sentence, .kind = ParameterKind::vector, .count = 3, .form = "[x, y, z]"}};
}
/// List of finite vectors.
template <class O>
constexpr auto param(std::string_view name, std::vector<Vec3> O::*member, std::string_view sentence) {
  return Parameter<O, std::vector<Vec3>>{member, {name, sentence, ParameterKind::vectors}};
}
/// N finite numbers.
template <class O, std::size_t N>
constexpr auto param(std::string_view name, std::array<double, N> O::*member, std::string_view sentence) {
  return Parameter<O, std::array<double, N>>{member,
                                             {.name = name, .sentence = sentence, .kind = ParameterKind::numbers, .count = N}};
}
template <class O, std::size_t N>
constexpr auto param(std::string_view name, std::optional<std::array<double, N>> O::*member, std::string_view sentence) {
  return Parameter<O, std::optional<std::array<double, N>>>{
      member, {.name = name, .sentence = sentence, .kind = ParameterKind::numbers, .count = N}};
}
/// N whole numbers, each within the range; zeros stand for none.
template <class O, std::size_t N>
constexpr auto param(std::string_view name, std::array<std::int64_t, N> O::*member, std::string_view sentence, Range range) {
  return Parameter<O, std::array<std::int64_t, N>>{
      member, {.name = name, .sentence = sentence, .kind = ParameterKind::whole_numbers, .range = range, .count = N}};
}
/// Choice of a word, stored as an enum with values 0, 1, 2, … in the order of the words, or as false and true.
template <class O, class Enum, class... Words>
constexpr auto choice_param(std::string_view name, Enum O::*member, std::string_view sentence, Words... words) {
  return Parameter<O, Enum, sizeof...(Words)>{member, {name, sentence, ParameterKind::choice}, {std::string_view(words)...}};
}
/// List of structs with a `parameters()` of their own.
template <class O, class Item>
constexpr auto list_param(std::string_view name, std::vector<Item> O::*member, std::string_view sentence) {
  return Parameter<O, std::vector<Item>>{member, {name, sentence, ParameterKind::list}};
}
/// Table of such structs, keyed by their parameter `name`.
template <class O, class Item>
constexpr auto named_list_param(std::string_view name, std::vector<Item> O::*member, std::string_view sentence) {
  return Parameter<O, std::vector<Item>>{member, {name, sentence, ParameterKind::named_tables}};
}
template <class O, class Item>
constexpr auto table_param(std::string_view name, Item O::*member, std::string_view sentence) {
  return Parameter<O, Item>{member, {name, sentence, ParameterKind::table}};
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

/// Adapter: struct as fixed list of size 1.
template <class Item>
class ListOfOne final : public ParameterList {
 public:
  explicit ListOfOne(Item& item) : item_(item) {}
  std::size_t size() const override { return 1; }
  void append() override {}
  void visit(std::size_t, ParameterVisitor& visitor) override { visit_parameters(item_, visitor); }
  void visit_default(ParameterVisitor& visitor) override {
    Item item;
    visit_parameters(item, visitor);
  }

 private:
  Item& item_;
};

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;

inline std::vector<double> numbers_of(const Vec3& v) { return {v.x, v.y, v.z}; }
inline void set_numbers(Vec3& v, const std::vector<double>& numbers) { v = {numbers[0], numbers[1], numbers[2]}; }
template <class T, std::size_t N>
std::vector<double> numbers_of(const std::array<T, N>& array) {
  const bool none = std::is_integral_v<T> && array == std::array<T, N>{};
  return none ? std::vector<double>{} : std::vector<double>(array.begin(), array.end());
}
template <class T, std::size_t N>
void set_numbers(std::array<T, N>& array, const std::vector<double>& numbers) {
  for (std::size_t i = 0; i < N; ++i) array[i] = static_cast<T>(numbers[i]);
}
template <class T>
std::vector<double> numbers_of(const std::optional<T>& value) {
  return value ? numbers_of(*value) : std::vector<double>{};
}
template <class T>
void set_numbers(std::optional<T>& value, const std::vector<double>& numbers) {
  set_numbers(value.emplace(), numbers);
}

template <class T>
void visit_numbers(const ParameterInfo& info, T& value, ParameterVisitor& visitor) {
  std::vector<double> numbers = numbers_of(value);
  visitor.numbers(info, numbers);
  if (numbers.size() == info.count) set_numbers(value, numbers);
}

/// Of an enum, a flag or an optional of these.
template <class T>
void visit_choice(const ParameterInfo& info, T& value, ParameterVisitor& visitor) {
  if constexpr (is_optional<T>) {
    int index = value ? static_cast<int>(*value) : -1;
    visitor.choice(info, index);
    if (index >= 0) value = static_cast<typename T::value_type>(index);
  } else {
    int index = static_cast<int>(value);
    visitor.choice(info, index);
    value = static_cast<T>(index);
  }
}

template <class T>
void visit_whole_number(const ParameterInfo& info, T& value, ParameterVisitor& visitor) {
  std::optional<std::int64_t> number;
  if constexpr (is_optional<T>) {
    if (value) number = *value;
  } else if (info.range.contains(static_cast<double>(value))) {
    number = value;
  }
  visitor.whole_number(info, number);
  if constexpr (is_optional<T>) {
    if (number) value = static_cast<typename T::value_type>(*number);
  } else {
    if (number) value = static_cast<T>(*number);
  }
}

template <class O, class T, std::size_t N>
void visit_parameter(O& owner, const Parameter<O, T, N>& p, ParameterVisitor& visitor) {
  ParameterInfo info = p.info;
  T& value = owner.*(p.member);
  if constexpr (N > 0) {
    info.choices = p.choices;
    visit_choice(info, value, visitor);
  } else if constexpr (std::is_same_v<T, double>) {
    visitor.number(info, value);
  } else if constexpr (std::is_same_v<T, std::optional<double>>) {
    visitor.optional_number(info, value);
  } else if constexpr (std::is_same_v<T, bool>) {
    visitor.flag(info, value);
  } else if constexpr (std::is_integral_v<T> || std::is_same_v<T, std::optional<int>>) {
    visit_whole_number(info, value, visitor);
  } else if constexpr (std::is_same_v<T, std::string>) {
    visitor.text(info, value);
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    visitor.texts(info, value);
  } else if constexpr (std::is_same_v<T, std::vector<Vec3>>) {
    visitor.vectors(info, value);
  } else if constexpr (std::is_same_v<T, FieldRef>) {
    visitor.field(info, value);
  } else if constexpr (std::is_same_v<T, Strength>) {
    visitor.strength(info, value);
  } else if constexpr (requires { numbers_of(value); }) {
    visit_numbers(info, value, visitor);
  } else if constexpr (is_vector<T>) {
    ListOf<typename T::value_type> list(value);
    visitor.list(info, list);
  } else {
    ListOfOne<T> table(value);
    visitor.list(info, table);
  }
}

template <class O>
void visit_parameter(O& owner, const Companion<O>& companion, ParameterVisitor& visitor) {
  if ((owner.*(companion.needed))()) visitor.companion(owner.*(companion.of), companion.felt);
}

template <class O>
void visit_parameter(O&, const ParameterInfo& other, ParameterVisitor& visitor) {
  visitor.other(other);
}

/// Visits a struct's own list, or, without a list, calls its owner's function `visit_part`.
template <class T>
void visit_parameters(T& owner, ParameterVisitor& visitor) {
  if constexpr (requires { T::parameters(); }) {
    const auto parameters = T::parameters();
    std::apply([&](const auto&... p) { (visit_parameter(owner, p, visitor), ...); }, parameters);
  } else {
    visit_part(owner, visitor);
  }
}

}  // namespace detail

}  // namespace palpa
