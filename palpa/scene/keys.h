// The keys of scene files. This one list drives loading, error messages and the documentation.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/core/coupling.h"
#include "palpa/mode/mode.h"

namespace palpa::detail {

enum class KeyKind : std::uint8_t {
  number,  ///< finite, within the bounds
  whole_number,
  flag,
  text,  ///< one of the choices, if there are any
  texts,
  numbers,         ///< a list of `count` finite numbers
  text_or_texts,   ///< one text, or a list of them
  text_or_number,  ///< one of the choices, or a number within the bounds
  text_or_position,
  strength,  ///< a number within the bounds, or a transfer function whose results are
  list,      ///< looked into where it is read
  table,
  tables,  ///< a list of tables
};

/// Numbers that are accepted: [low, high], or (low, high].
struct Bounds {
  double low;
  double high;
  bool above_low = false;
  bool contain(double value) const noexcept { return (above_low ? value > low : value >= low) && value <= high; }
};
/// "above 0 and at most 100".
std::string sentence_of(const Bounds& bounds);

struct Key {
  std::string name;
  KeyKind kind = KeyKind::text;
  std::string form;      ///< how its value is written, for people; empty: by the kind
  std::string fallback;  ///< what holds when it is left out, for people; "required" where it must be given
  std::string sentence;
  std::optional<Bounds> bounds = {};
  std::vector<std::string> choices = {};
  std::size_t count = 0;        ///< of numbers
  std::vector<Key> items = {};  ///< the keys of the tables of a mode's list
  bool required() const noexcept { return fallback == "required"; }
};
using Keys = std::vector<Key>;

const Key* find(const Keys& keys, std::string_view name) noexcept;
std::vector<std::string> names_of(const Keys& keys);
/// What a value of this key looks like: "number [N], between 0 and 100".
std::string form_of(const Key& key);

const Keys& scene_keys();
const Keys& coupling_keys();
const Keys& law_keys();
const Keys& workspace_keys();
const Keys& time_keys();
const Keys& file_keys();  ///< of a volume: how its file is read
const Keys& volume_keys();
const Keys& volume_field_keys();  ///< of volume.NAME.fields.NAME
const Keys& pose_keys();
const Keys& poses_keys();     ///< of each of `poses`
const Keys& mode_keys();      ///< those that every mode has
const Keys& function_keys();  ///< of a strength that is a transfer function, and of a mask
const Keys& view_keys();
const Keys& view_layer_keys();
const Keys& view_colors_keys();

/// The keys of a mode's own parameters.
Keys parameter_keys(const Mode& mode);

/// The member that a key of [coupling] sets.
double CouplingOptions::*coupling_member(std::string_view key) noexcept;

inline const std::vector<std::string>& law_methods() {
  static const std::vector<std::string> methods{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};
  return methods;
}

}  // namespace palpa::detail
