#include "zarr_vectors.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>

namespace palpa::reader {
namespace {

struct ComponentName {
  std::string common;
  char letter = ' ';
};

/// Label as a component: "vx", "velocity_y", "w". None for other labels.
std::optional<ComponentName> component_of(const std::string& label) {
  std::string small;
  for (const char c : label) small += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (small.empty() || small.back() < 'u' || small.back() > 'z') return std::nullopt;
  ComponentName found{small.substr(0, small.size() - 1), small.back()};
  const bool is_apart = !found.common.empty() && std::string_view("_-.: ").find(found.common.back()) != std::string_view::npos;
  static constexpr std::string_view joined[] = {"", "u", "v", "b", "e", "f", "vel", "velocity", "wind"};
  if (!is_apart && std::ranges::find(joined, found.common) == std::end(joined)) return std::nullopt;
  found.common.resize(found.common.find_last_not_of("_-.: ") + 1);
  return found;
}

/// Channels of the vector of which a channel is the first component; empty: none.
std::vector<std::int64_t> vector_from(const std::vector<std::string>& labels, std::size_t first) {
  const auto begin = component_of(labels[first]);
  if (!begin) return {};
  for (const std::string_view letters : {"xyz", "uvw"}) {
    if (begin->letter != letters[0] || (letters == "uvw" && !begin->common.empty())) continue;
    std::vector<std::int64_t> found;
    for (const char letter : letters) {
      for (std::size_t n = 0; n < labels.size(); ++n) {
        const auto other = component_of(labels[n]);
        if (other && other->common == begin->common && other->letter == letter) found.push_back(static_cast<std::int64_t>(n));
      }
    }
    if (found.size() == 3) return found;
  }
  return {};
}

}  // namespace

ZarrFields fields_of_channels(const std::vector<std::string>& labels, std::size_t count, bool is_plain) {
  ZarrFields made;
  if (is_plain && count == 3) {
    made.fields.push_back({"vector", {0, 1, 2}});
    return made;
  }
  std::vector<std::string> names(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(std::min(labels.size(), count)));
  made.are_named = count > 1 || (!names.empty() && !names.front().empty());
  names.resize(count);
  std::vector<std::vector<std::int64_t>> vectors(count);
  std::vector<bool> is_taken(count, false);
  for (std::size_t n = 0; n < count; ++n) {
    vectors[n] = vector_from(names, n);
    for (const std::int64_t channel : vectors[n]) is_taken[static_cast<std::size_t>(channel)] = true;
  }
  for (std::size_t n = 0; n < count; ++n) {
    if (is_taken[n] && vectors[n].empty()) continue;
    std::string name = names[n].empty() ? (count == 1 ? "value" : "channel" + std::to_string(n)) : names[n];
    if (!vectors[n].empty()) {
      const std::string common = component_of(names[n])->common;
      name = common.size() > 1 ? common : "velocity";
    }
    const auto has = [&](const std::string& other) {
      return std::ranges::any_of(made.fields, [&](const ZarrFields::Field& field) { return field.name == other; });
    };
    for (int copy = 2; has(name); ++copy) name = names[n] + "_" + std::to_string(copy);
    made.fields.push_back({name, vectors[n].empty() ? std::vector{static_cast<std::int64_t>(n)} : vectors[n]});
  }
  return made;
}

}  // namespace palpa::reader
