#include "palpa/scene/change_text.h"

#include <toml++/toml.h>

#include <algorithm>

#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/scene/scene.h"

namespace palpa {
namespace {

toml::table parsed(const std::string& text) {
  if (const auto problem = detail::problem_with_toml(text)) throw SceneError("scene: " + problem->sentence);
  try {
    return toml::parse(std::string_view(text));
  } catch (const toml::parse_error& error) {
    throw SceneError(detail::one_line("scene: no valid TOML: " + std::string(error.description()) + "; change it by hand"));
  }
}

/// Offset of a line in the text. \param line  [1] from 1
std::size_t begin_of_line(const std::string& text, std::size_t line) {
  std::size_t at = 0;
  for (std::size_t n = 1; n < line && at < text.size(); ++n) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  return at;
}

/// Columns of toml++ count characters, not bytes.
std::size_t after_characters(const std::string& text, std::size_t at, std::size_t characters) {
  const auto goes_on = [&](std::size_t n) { return n < text.size() && (static_cast<unsigned char>(text[n]) & 0xC0) == 0x80; };
  for (; characters > 0 && at < text.size(); --characters) {
    do ++at;
    while (goes_on(at));
  }
  return at;
}

}  // namespace

std::string with_number(const std::string& text, std::string_view table, std::string_view key, double value) {
  const toml::table scene = parsed(text);
  const std::string number = detail::toml_number(value);
  const toml::table* const found = scene[table].as_table();
  if (!found) {
    const std::string end = text.empty() || text.back() == '\n' ? "" : "\n";
    return text + end + "\n[" + std::string(table) + "]\n" + std::string(key) + " = " + number + "\n";
  }
  std::string changed = text;
  if (const toml::node* const there = found->get(key)) {
    const toml::source_region& region = there->source();
    const std::size_t begin = after_characters(text, begin_of_line(text, region.begin.line), region.begin.column - 1);
    // A number ends at the first character that may follow it.
    const std::size_t end = std::min(text.find_first_of(" \t\r\n,}#", begin), text.size());
    return changed.replace(begin, end - begin, number);
  }
  const std::string line = std::string(key) + " = " + number;
  const std::size_t begin = begin_of_line(text, found->source().begin.line);
  if (found->is_inline()) {
    const std::size_t open = after_characters(text, begin, found->source().begin.column - 1) + 1;
    return changed.insert(open, line + (found->empty() ? "" : ", "));
  }
  const std::size_t next = text.find('\n', begin);
  if (next == std::string::npos) return changed + "\n" + line + "\n";
  return changed.insert(next + 1, line + "\n");
}

}  // namespace palpa
