#include "palpa/scene/set_path.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/scene/toml_section.h"

namespace palpa::detail::scene_file {

using detail::in_quotes;
using detail::suggestion;

namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) c == '.' ? parts.emplace_back() : parts.back() += c;
  return parts;
}

toml::source_region region(const std::string& place) { return {{1, 1}, {1, 1}, std::make_shared<const std::string>(place)}; }

}  // namespace

void SetPath::set(const std::string& path, const std::string& value) {
  const std::string place = std::string(set_mark) + path;
  const std::vector<std::string> parts = split(path);
  const std::size_t n = parts.size();
  constexpr std::array tables = {"coupling", "workspace", "time", "tool", "view"};
  if (n == 2 && (path == "law.method" || std::ranges::find(tables, parts[0]) != tables.end()))
    return put(subtable(root_, parts[0], place), parts[1], value, place);
  if (path == "only_hand") return put(&root_, path, value, place);
  if (n == 3 && parts[0] == "volume") {
    toml::table* volumes = root_["volume"].as_table();
    std::vector<std::string> names;
    if (volumes) {
      for (const auto& [key, node] : *volumes) names.emplace_back(key.str());
    }
    if (!volumes || !volumes->contains(parts[1]))
      fail(place, "no volume " + in_quotes(parts[1]) + "; " + suggestion(parts[1], names));
    return put((*volumes)[parts[1]].as_table(), parts[2], value, place);
  }
  if ((n == 3 || n == 5) && parts[0] == "mode") {
    toml::table& mode = item(root_, "mode", parts[1], "mode", place);
    if (n == 3) return put(&mode, parts[2], value, place);
    return put(&item(mode, parts[2], parts[3], parts[2], place), parts[4], value, place);
  }
  if (parts[0] == "hand" && (n == 3 || (n == 4 && parts[2] == "tool"))) {
    toml::table& hand = item(root_, "hand", parts[1], "hand", place);
    return n == 3 ? put(&hand, parts[2], value, place) : put(subtable(hand, "tool", place), parts[3], value, place);
  }
  fail(place,
       "no such path; there are: coupling.KEY, law.method, workspace.KEY, volume.NAME.KEY, mode.NAME.KEY, "
       "mode.NAME.level.NAME.KEY, time.KEY, tool.KEY, hand.NAME.KEY, hand.NAME.tool.KEY, only_hand, view.KEY");
}

// A new one where there is none.
toml::table* SetPath::subtable(toml::table& owner, const std::string& key, const std::string& place) {
  if (!owner.contains(key)) owner.insert(toml::key(key, region(place)), toml::table{});
  return owner[key].as_table();
}

// Values that are no TOML are texts, so that words need no quotes.
void SetPath::put(toml::table* table, const std::string& key, const std::string& value, const std::string& place) {
  if (!table) return;  // not a table: the checks will say so
  const std::string line = "v = " + value;
  toml::table parsed;
  if (value.size() <= limit::scene_bytes.count() && !detail::problem_with_toml(line)) {
    try {
      parsed = toml::parse(std::string_view(line), std::string_view(place));
    } catch (const toml::parse_error&) {
      parsed.clear();
    }
  }
  toml::node* node = parsed.size() == 1 ? parsed.get("v") : nullptr;
  if (!node) {
    parsed = toml::parse(std::string_view("v = " + detail::toml_string(value)), std::string_view(place));
    node = parsed.get("v");
  }
  // The key's own place is --set as well, even where it replaces one of the file.
  table->erase(key);
  table->insert_or_assign(toml::key(key, region(place)), std::move(*node));
}

toml::table& SetPath::item(toml::table& owner, const std::string& list, const std::string& name, const std::string& kind,
                           const std::string& place) {
  std::vector<std::string> names;
  if (toml::array* items = owner[list].as_array()) {
    for (toml::node& element : *items) {
      toml::table* table = element.as_table();
      const std::optional<std::string> found = table ? (*table)["name"].value<std::string>() : std::nullopt;
      if (found == name) return *table;
      if (found) names.push_back(*found);
    }
  }
  fail(place, "no " + kind + " " + in_quotes(name) + "; " + suggestion(name, names));
}

}  // namespace palpa::detail::scene_file
