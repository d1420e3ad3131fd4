#include <algorithm>

#include "palpa/data/analytic.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/load_scene.h"

namespace palpa {

namespace {

using detail::Key;
using detail::Keys;

std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
  return text;
}

std::string row(const Key& key) {
  const std::string fallback = key.fallback.empty() ? "–" : key.required ? "**required**" : key.fallback;
  return "| `" + key.name + "` | " + cell(form_of(key)) + " | " + cell(fallback) + " | " + cell(key.sentence) + " |\n";
}

std::string table(const Keys& keys) {
  std::string out = "| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const Key& key : keys) out += row(key);
  return out;
}

std::string section(const std::string& title, const Keys& keys) { return "### " + title + "\n\n" + table(keys) + "\n"; }

/// Width of a text on a screen: characters, not bytes.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to) {
  return text + std::string(to > width(text) ? to - width(text) : 0, ' ');
}

std::string lines(const Keys& keys) {
  std::size_t name = 0, form = 0, fallback = 0;
  for (const Key& key : keys) {
    name = std::max(name, width(key.name));
    form = std::max(form, width(form_of(key)));
    fallback = std::max(fallback, width(key.fallback));
  }
  std::string out;
  for (const Key& key : keys) {
    out += "  " + padded(key.name, name + 2) + padded(form_of(key), form + 2) + padded(key.fallback, fallback + 2) +
           key.sentence + "\n";
  }
  return out;
}

}  // namespace

std::string scene_reference_markdown(const ModeCatalog& modes) {
  const Keys& volume_keys = detail::keys_of<detail::VolumePart>();
  std::string out = section("The scene", detail::keys_of<detail::HeaderPart>());
  out += section("`[coupling]`", detail::keys_of<CouplingOptions>());
  out += section("`[law]`", detail::keys_of<detail::LawPart>());
  out += section("`[workspace]`", detail::keys_of<Workspace>());
  out += section("`[time]`", detail::keys_of<TimeOptions>());
  out += section("`[tool]`", detail::keys_of<ToolOptions>());
  out += section("`[[hand]]`", detail::keys_of<SceneHand>());
  out += section("`[volume.NAME]`", volume_keys);
  out += section("`fields` of a volume, for each `NAME`", find(volume_keys, "fields")->items);
  out += section("`pose` of a volume", find(volume_keys, "pose")->items);
  out += section("Each of the `poses` of a volume", find(volume_keys, "poses")->items);
  out += "### Embedded data (`analytic`)\n\n| name | what it is |\n|---|---|\n";
  for (const auto& volumes : {analytic_volumes(), beating_volumes()}) {
    for (const AnalyticVolume& volume : volumes) {
      out += "| `" + std::string(volume.name) + "` | " + cell(std::string(volume.sentence)) + " |\n";
    }
  }
  out += "\n" + section("`[[mode]]`, whatever its type", detail::keys_of<detail::ModePart>());
  out += "### Types of modes\n\n| type | what it feels like |\n|---|---|\n";
  for (const Mode& mode : modes.modes()) {
    const std::string type(mode.type());
    out += "| [`" + type + "`](modes/" + type + ".md) | " + cell(std::string(mode.summary())) + " |\n";
  }
  out += "\n" + section("A function of a field (STRENGTH, `mask`)", detail::keys_of<detail::FunctionPart>());
  out += section("`[view]`", detail::keys_of<ViewOptions>());
  out += section("`[[view.layer]]`", detail::keys_of<ViewLayer>());
  out += section("`colors` of a layer", detail::keys_of<detail::ColorsPart>());
  out.pop_back();
  return out;
}

std::string mode_reference_markdown(const Mode& mode) {
  const Keys keys = detail::parameter_keys(mode);
  std::string out = table(keys);
  for (const Key& key : keys) {
    if (!key.items.empty()) out += "\nEach `[[mode." + key.name + "]]`:\n\n" + table(key.items);
  }
  return out;
}

std::string mode_reference_text(const Mode& mode) {
  const Keys keys = detail::parameter_keys(mode);
  std::string out = std::string(mode.type()) + ": " + std::string(mode.summary()) + "\n\n" + lines(keys);
  for (const Key& key : keys) {
    if (!key.items.empty()) out += "\nEach [[mode." + key.name + "]]:\n" + lines(key.items);
  }
  return out + "\nEvery mode:\n" + lines(detail::keys_of<detail::ModePart>()) +
         "\nFIELD is VOLUME, VOLUME.FIELD or FUNCTION(FIELD), as in magnitude(flow.velocity).\n"
         "STRENGTH is newtons, or a function of a field's value: {of = FIELD, points = [[value, newtons], ...]}.\n";
}

}  // namespace palpa
