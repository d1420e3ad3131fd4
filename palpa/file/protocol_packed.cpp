#include "palpa/file/protocol_packed.h"

#include "palpa/base/input_file.h"

namespace palpa::protocol {

bool is_packed(const std::string& path) {
  const detail::InputFile file(path);
  unsigned char mark[2] = {};
  return file.is_open() && file.read(0, mark, sizeof mark) == sizeof mark && mark[0] == 0x1f && mark[1] == 0x8b;
}

}  // namespace palpa::protocol
