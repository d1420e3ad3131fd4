// Optional vendor library, loaded at run time, never linked.
#pragma once

#include <string>
#include <vector>

namespace palpa {

/// Loaded once and kept. Unusable without the library or any of its required functions.
class VendorLibrary {
 public:
  /// \param files  names for dlopen, or paths, the best first; folders may come from the environment
  explicit VendorLibrary(const std::vector<std::string>& files);

  bool is_there() const noexcept { return handle_ != nullptr; }
  const std::string& file() const noexcept { return file_; }            ///< loaded
  const std::string& complaint() const noexcept { return complaint_; }  ///< of the loader, one line: why loading failed

  /// Optional function; null: missing in this version.
  template <class Function>
  void find(const char* name, Function*& function) const noexcept {
    function = reinterpret_cast<Function*>(symbol(name));
  }
  /// Required function; its name is noted if missing.
  template <class Function>
  void need(const char* name, Function*& function) {
    find(name, function);
    if (function == nullptr) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
  }
  const std::string& missing() const noexcept { return missing_; }

 private:
  void* symbol(const char* name) const noexcept;

  void* handle_ = nullptr;
  std::string file_, complaint_, missing_;
};

}  // namespace palpa

/// Declares the libraries that this shared object loads at run time, for packagers, in an ELF note (FDO packaging metadata,
/// .note.dlopen): JSON, owner "FDO", type 0x407c0c0a.
#define PALPA_LOADS_AT_RUN_TIME(json)                                                        \
  namespace {                                                                                \
  struct alignas(4) DlopenNote {                                                             \
    unsigned owner_bytes = 4, text_bytes = sizeof(json), type = 0x407c0c0a;                  \
    char owner[4] = {'F', 'D', 'O', 0};                                                      \
    alignas(4) char text[(sizeof(json) + 3) / 4 * 4] = json;                                 \
  };                                                                                         \
  [[gnu::used, gnu::section(".note.dlopen"), gnu::aligned(4)]] const DlopenNote dlopen_note; \
  }
