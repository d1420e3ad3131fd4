// Small checker of well-formed markup, for SVG (strict) and Palpa's HTML.
#pragma once

#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace palpa {

/// The first error in `text`; empty: none. Tags open and close in order, attributes are quoted and unique, `<` and bare `&` are
/// escaped. `html`: a doctype comes first, some elements have no end, a style holds plain text, and a script anything up to its
/// end.
inline std::string markup_error(std::string_view text, bool html) {
  static const std::set<std::string_view> without_end{"meta", "img", "br", "hr", "link", "input"};
  std::vector<std::string> open;
  std::size_t at = 0;
  const auto wrong = [&](const std::string& what) { return what + " near byte " + std::to_string(at); };
  const auto bad_entity = [](std::string_view content) {
    for (std::size_t i = content.find('&'); i != std::string_view::npos; i = content.find('&', i + 1)) {
      const std::size_t end = content.find(';', i);
      if (end == std::string_view::npos || end - i > 10 || end == i + 1) return true;
      for (std::size_t j = i + 1; j < end; ++j) {
        if (!std::isalnum(static_cast<unsigned char>(content[j])) && content[j] != '#') return true;
      }
    }
    return false;
  };
  if (html) {
    if (!text.starts_with("<!DOCTYPE html>")) return "no doctype";
    at = 15;
  }
  bool root_seen = false;
  while (at < text.size()) {
    if (!open.empty() && open.back() == "script" && text.substr(at, 8) != "</script") {
      at = std::min(text.find("</script", at), text.size());
      continue;
    }
    if (text[at] != '<') {
      const std::size_t end = std::min(text.find('<', at), text.size());
      const std::string_view content = text.substr(at, end - at);
      const bool raw = !open.empty() && open.back() == "style";
      if (!raw && bad_entity(content)) return wrong("bare '&'");
      if (content.find('>') != std::string_view::npos && !raw) return wrong("bare '>'");
      if (open.empty() && content.find_first_not_of(" \n") != std::string_view::npos) return wrong("text outside");
      at = end;
      continue;
    }
    std::size_t next = at + 1;
    const bool closing = next < text.size() && text[next] == '/';
    if (closing) ++next;
    std::string name;
    while (next < text.size() && (std::isalnum(static_cast<unsigned char>(text[next])) || text[next] == ':'))
      name += text[next++];
    if (name.empty()) return wrong("'<' without a name");
    if (closing) {
      if (next >= text.size() || text[next] != '>') return wrong("end tag with more in it");
      if (open.empty() || open.back() != name) return wrong("</" + name + "> closes nothing");
      open.pop_back();
      at = next + 1;
      continue;
    }
    if (open.empty() && root_seen) return wrong("a second root");
    root_seen = true;
    std::set<std::string> attributes;
    while (true) {
      while (next < text.size() && std::isspace(static_cast<unsigned char>(text[next]))) ++next;
      if (next >= text.size()) return wrong("tag without end");
      if (text[next] == '>' || text[next] == '/') break;
      std::string attribute;
      while (next < text.size() &&
             (std::isalnum(static_cast<unsigned char>(text[next])) || text[next] == '-' || text[next] == ':')) {
        attribute += text[next++];
      }
      if (attribute.empty() || text.substr(next, 2) != "=\"")
        return wrong("attribute '" + attribute + "' without a value in <" + name);
      if (!attributes.insert(attribute).second) return wrong("attribute '" + attribute + "' twice");
      const std::size_t end = text.find('"', next + 2);
      if (end == std::string_view::npos) return wrong("value without end");
      const std::string_view value = text.substr(next + 2, end - next - 2);
      if (value.find('<') != std::string_view::npos || bad_entity(value)) return wrong("value not escaped");
      next = end + 1;
    }
    const bool empty = text[next] == '/';
    if (empty) ++next;
    if (next >= text.size() || text[next] != '>') return wrong("tag without end");
    if (!empty && !(html && without_end.contains(name))) open.push_back(name);
    at = next + 1;
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

}  // namespace palpa
