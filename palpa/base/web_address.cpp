#include "palpa/base/web_address.h"

#include <algorithm>

namespace palpa {

bool is_web_address(const std::filesystem::path& path) noexcept {
  const std::string& text = path.native();
  return text.starts_with("http://") || text.starts_with("https://");
}

namespace detail {

std::string problem_with_web_address(std::string_view address) {
  constexpr std::size_t longest = 2000;  // More: servers refuse it with a chunk's name behind; less: long paths are refused
  const std::string_view rest = address.substr(std::min(address.find("://"), address.size() - 3) + 3);
  const std::string_view host = rest.substr(0, rest.find('/'));
  if (host.empty() || host.front() == ':') return "names no server; give http://SERVER/PATH";
  if (address.size() > longest) return "is longer than 2000 bytes; give a shorter address";
  if (host.find('@') != host.npos) return "names a user; give an address that needs none";
  if (address.find_first_of("?#") != address.npos)
    return "has a query or a fragment ('?', '#'), behind which no file of a store can stand; give a plain address";
  if (rest.find("/../") != rest.npos || rest.ends_with("/..")) return "has a '..'; give the address that is meant";
  const auto is_known = [](char c) {
    constexpr std::string_view marks = "-._~%/:[]!$&'()*+,;=@";
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || marks.find(c) != marks.npos;
  };
  if (!std::ranges::all_of(address, is_known))
    return "has a blank or another character that no address has; write it as %20, or as its own code";
  return {};
}

std::filesystem::path absolute_place(const std::filesystem::path& path, bool normal) {
  if (is_web_address(path)) return path;
  const std::filesystem::path whole = std::filesystem::absolute(path);
  return normal ? whole.lexically_normal() : whole;
}

}  // namespace detail
}  // namespace palpa
