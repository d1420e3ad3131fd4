// Writer of gzip files.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "palpa/base/new_file.h"

namespace palpa::detail {

/// Packs bytes, written in pieces of any size. The same bytes give the same file: no time, no name. Throws LoadError as NewFile
/// does. One thread.
class GzipWriter {
 public:
  explicit GzipWriter(NewFile& to);
  ~GzipWriter();
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void finish();  ///< writes the last bytes; once

 private:
  struct State;
  void put(int flush);

  NewFile& to_;
  std::unique_ptr<State> state_;
};

}  // namespace palpa::detail
