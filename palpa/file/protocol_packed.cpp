#include "palpa/file/protocol_packed.h"

#include <algorithm>
#include <string_view>

#include "palpa/disk/input_file.h"

namespace palpa::protocol {

bool is_packed(const std::string& path) {
  const detail::InputFile file(path);
  unsigned char mark[2] = {};
  return file.is_open() && file.read(0, mark, sizeof mark) == sizeof mark && mark[0] == 0x1f && mark[1] == 0x8b;
}

bool may_be_deflated(const std::string& path) {
  const detail::InputFile file(path);
  if (file.why_not() == detail::NoInput::folder) return true;
  char bytes[1024] = {};  // the syntax stands among the first elements
  const std::string_view start(bytes, file.is_open() ? file.read(0, bytes, sizeof bytes) : 0);
  return start.substr(std::min<std::size_t>(128, start.size())).starts_with("DICM") &&
         start.find("1.2.840.10008.1.2.1.99") != std::string_view::npos;
}

}  // namespace palpa::protocol
