// Modes from shared libraries: the plug-in macro and the loader.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/version.h"

namespace palpa {

/// Adds the modes of a plug-in, a shared library that ends with PALPA_MODES(…), to a catalog. Its stamp is read from the file
/// before any of its code runs; another version's is refused. A path without a slash is a file in the current folder: the
/// system's library folders are never searched. A plug-in runs with all rights of this process: load only trusted files. It
/// stays loaded until the process ends, because modes may live as long. Throws LoadError and leaves the catalog unchanged.
/// Allocates; not for the tick; one thread at a time for one catalog.
void load_plugin(const std::filesystem::path& file, ModeCatalog& catalog);

/// Modes of the library and of these plug-ins. Throws LoadError.
ModeCatalog modes_with(const std::vector<std::filesystem::path>& plugins);

namespace detail {

/// Binary interface that a plug-in and its loader must share, as stored in the file.
struct PluginAbi {
  std::uint32_t major = 0;   ///< of the version; before 1.0 a new minor is another interface
  std::uint32_t minor = 0;   ///< of the version
  std::uint64_t layout = 0;  ///< of the passed types: sizes, and the standard library's switches
  friend constexpr bool operator==(const PluginAbi&, const PluginAbi&) = default;
};

/// An ELF note: owner "palpa", type 1, the ABI.
struct PluginStamp {
  std::uint32_t owner_bytes = 6;
  std::uint32_t abi_bytes = sizeof(PluginAbi);
  std::uint32_t type = 1;
  std::array<char, 8> owner{"palpa"};  // padded to four bytes
  std::array<std::uint32_t, 4> abi{};  // as words: a note is aligned to four bytes
};
static_assert(sizeof(PluginStamp) == 20 + sizeof(PluginAbi), "a note has no gaps");

/// ABI of the headers being compiled.
constexpr PluginAbi plugin_abi() {
  PluginAbi abi;
  const char* digit = version;
  for (; *digit != '.'; ++digit) abi.major = 10 * abi.major + static_cast<std::uint32_t>(*digit - '0');
  for (++digit; *digit != '.'; ++digit) abi.minor = 10 * abi.minor + static_cast<std::uint32_t>(*digit - '0');

#ifdef _GLIBCXX_USE_CXX11_ABI
  constexpr std::uint64_t strings = _GLIBCXX_USE_CXX11_ABI + 1;
#else
  constexpr std::uint64_t strings = 0;
#endif
#ifdef _GLIBCXX_DEBUG
  constexpr std::uint64_t checked = 1;
#else
  constexpr std::uint64_t checked = 0;
#endif
  abi.layout = 14695981039346656037u;  // FNV-1a over the numbers
  for (const std::uint64_t number :
       {strings, checked, std::uint64_t{sizeof(std::string)}, std::uint64_t{sizeof(Mode)}, std::uint64_t{sizeof(ModeContext)},
        std::uint64_t{sizeof(StepResult)}, std::uint64_t{sizeof(Contact)}, std::uint64_t{sizeof(Crossing)},
        std::uint64_t{sizeof(PrimitiveSet)}, std::uint64_t{sizeof(ScalarSample)}, std::uint64_t{sizeof(VectorSample)},
        std::uint64_t{sizeof(Strength)}, std::uint64_t{sizeof(FieldRef)}, std::uint64_t{sizeof(ParameterInfo)},
        std::uint64_t{sizeof(TransferFunction)}}) {
    abi.layout = (abi.layout ^ number) * 1099511628211u;
  }
  return abi;
}

/// ABI of this library's build, for programs compiled apart.
PluginAbi library_abi() noexcept;

/// ELF note of an ABI.
constexpr PluginStamp plugin_stamp(const PluginAbi& abi) {
  PluginStamp stamp;
  stamp.abi = {abi.major, abi.minor, static_cast<std::uint32_t>(abi.layout), static_cast<std::uint32_t>(abi.layout >> 32)};
  return stamp;
}

template <class... M>
void append_modes(std::vector<Mode>& modes) {
  (modes.emplace_back(M{}), ...);
}

}  // namespace detail
}  // namespace palpa

/// Makes a shared library a plug-in: PALPA_MODES(Ridge, Groove), once, outside of all namespaces. Adds a stamp, which is read
/// without running the library, and a function that returns the modes.
#define PALPA_MODES(...)                                                                                                      \
  extern "C" {                                                                                                                \
  [[gnu::used, gnu::section(".note.palpa"), gnu::aligned(4)]] constinit const palpa::detail::PluginStamp palpa_plugin_stamp = \
      palpa::detail::plugin_stamp(palpa::detail::plugin_abi());                                                               \
  [[gnu::visibility("default")]] void palpa_plugin_modes(std::vector<palpa::Mode>& modes) {                                   \
    palpa::detail::append_modes<__VA_ARGS__>(modes);                                                                          \
  }                                                                                                                           \
  }
