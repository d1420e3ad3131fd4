#include "palpa/mode/plugin.h"

#include <dlfcn.h>
#include <elf.h>

#include <bit>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

#if defined(__x86_64__)
constexpr std::uint16_t own_machine = EM_X86_64;
#elif defined(__aarch64__)
constexpr std::uint16_t own_machine = EM_AARCH64;
#else
#error "which ELF machine is this?"
#endif
static_assert(std::endian::native == std::endian::little && sizeof(void*) == 8, "the ELF files read here are these");

// Limits on the sizes in a damaged file. Larger: more memory for nonsense; smaller: could refuse a linker's output, some
// hundred bytes and about ten segments.
constexpr std::uint64_t most_notes_bytes = 1 << 20;
constexpr std::uint16_t most_segments = 1024;

/// File with random-access reads, each checked against its size.
class File {
 public:
  explicit File(const fs::path& path) : file_(path) {
    constexpr const char* right = "a plug-in is a shared library that ends with PALPA_MODES(…)";
    switch (file_.why_not()) {
      case detail::NoInput::none: return;
      case detail::NoInput::missing: refuse(std::string("no such file; ") + right);
      case detail::NoInput::unreadable: refuse(file_.problem() + "; a plug-in is a file that you may read");
      default: refuse(std::string("is no file; ") + right);
    }
  }

  [[noreturn]] void refuse(const std::string& why) const { throw LoadError(file_.path().string() + ": " + why); }
  [[noreturn]] void refuse_as_damaged() const { refuse("is a damaged shared library (cut short?); build it again"); }

  bool holds(std::uint64_t offset, std::uint64_t bytes) const noexcept {
    return bytes <= file_.bytes() && offset <= file_.bytes() - bytes;
  }
  void read(std::uint64_t offset, void* to, std::size_t bytes) const {
    if (!holds(offset, bytes) || file_.read(offset, to, bytes) != bytes) refuse_as_damaged();
  }
  template <class T>
  T at(std::uint64_t offset) const {
    T value;
    read(offset, &value, sizeof value);
    return value;
  }

 private:
  detail::InputFile file_;
};

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

/// The ABI of the stamp in a piece of notes, if it has one.
std::optional<detail::PluginAbi> stamp_in(const std::vector<char>& notes) {
  const detail::PluginStamp expected;
  for (std::size_t at = 0; notes.size() - at >= sizeof(Elf64_Nhdr);) {
    Elf64_Nhdr note;
    std::memcpy(&note, notes.data() + at, sizeof note);
    at += sizeof note;
    const std::size_t left = notes.size() - at;
    if (note.n_namesz > left || note.n_descsz > left || padded(note.n_namesz) > left) break;
    const std::size_t text = padded(note.n_namesz);
    if (note.n_descsz > left - text) break;
    if (note.n_namesz == expected.owner_bytes && note.n_type == expected.type && note.n_descsz == expected.abi_bytes &&
        std::memcmp(notes.data() + at, expected.owner.data(), expected.owner_bytes) == 0) {
      detail::PluginAbi abi;
      std::memcpy(&abi.major, notes.data() + at + text, 4);
      std::memcpy(&abi.minor, notes.data() + at + text + 4, 4);
      std::memcpy(&abi.layout, notes.data() + at + text + 8, 8);
      return abi;
    }
    at += std::min(left, text + padded(note.n_descsz));
  }
  return std::nullopt;
}

/// Stamp of an undamaged shared library for this machine; none if it has no stamp.
std::optional<detail::PluginAbi> read_stamp(const File& file) {
  constexpr const char* no_library = "is no shared library; a plug-in is one that ends with PALPA_MODES(…)";
  if (!file.holds(0, SELFMAG)) file.refuse(no_library);
  std::array<unsigned char, SELFMAG> magic;
  file.read(0, magic.data(), magic.size());
  if (std::memcmp(magic.data(), ELFMAG, SELFMAG) != 0) file.refuse(no_library);
  const auto header = file.at<Elf64_Ehdr>(0);
  if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_ident[EI_DATA] != ELFDATA2LSB || header.e_machine != own_machine) {
    file.refuse("is made for another kind of machine; build it on this one");
  }
  if (header.e_type != ET_DYN) file.refuse(no_library);
  if (header.e_phentsize != sizeof(Elf64_Phdr) || header.e_phnum == 0 || header.e_phnum > most_segments)
    file.refuse_as_damaged();

  // The system's loader trusts these numbers: offsets beyond the end of the file would end the process.
  const std::uint64_t sections_bytes = std::uint64_t{header.e_shnum} * header.e_shentsize;
  if (header.e_shoff != 0 && !file.holds(header.e_shoff, sections_bytes)) file.refuse_as_damaged();

  std::optional<detail::PluginAbi> stamp;
  for (std::uint16_t i = 0; i < header.e_phnum; ++i) {
    if (header.e_phoff > UINT64_MAX / 2) file.refuse_as_damaged();
    const auto segment = file.at<Elf64_Phdr>(header.e_phoff + i * sizeof(Elf64_Phdr));
    if (!file.holds(segment.p_offset, segment.p_filesz) || segment.p_filesz > segment.p_memsz) file.refuse_as_damaged();
    if (segment.p_type != PT_NOTE || stamp) continue;
    if (segment.p_filesz > most_notes_bytes) file.refuse_as_damaged();
    std::vector<char> notes(segment.p_filesz);
    file.read(segment.p_offset, notes.data(), notes.size());
    stamp = stamp_in(notes);
  }
  return stamp;
}

std::string text_of(const detail::PluginAbi& abi) { return std::to_string(abi.major) + "." + std::to_string(abi.minor); }

void check_stamp(const File& file) {
  constexpr detail::PluginAbi own = detail::plugin_abi();
  const std::optional<detail::PluginAbi> stamp = read_stamp(file);
  if (!stamp) file.refuse("is a library or program, but no plug-in; a plug-in ends with PALPA_MODES(…)");
  if (stamp->major != own.major || stamp->minor != own.minor) {
    file.refuse("is made for palpa " + text_of(*stamp) + ", this is palpa " + text_of(own) + "; rebuild it");
  }
  if (*stamp != own) {
    file.refuse(
        "is made with other headers of palpa " + text_of(own) +
        " or with another kind of standard library; rebuild it with those of this palpa (docs/changes.md: old and new names)");
  }
}

/// Message of the system's loader without the path, which our line begins with.
std::string complaint_of_loader(const std::string& path) {
  const char* error = ::dlerror();
  std::string text = error ? error : "no reason given";
  if (text.rfind(path + ": ", 0) == 0) text.erase(0, path.size() + 2);
  return text;
}

}  // namespace

void load_plugin(const fs::path& path, ModeCatalog& catalog) {
  const File file(path);
  check_stamp(file);

  const std::string absolute = fs::absolute(path).string();  // with a slash: no search through library folders
  void* const library = ::dlopen(absolute.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    file.refuse("cannot be loaded (" + complaint_of_loader(absolute) + "); link it with all that it uses");
  }
  // Never closed: modes and their exceptions hold addresses in it.
  const auto give_modes = reinterpret_cast<void (*)(std::vector<Mode>&)>(::dlsym(library, "palpa_plugin_modes"));
  if (!give_modes) file.refuse("has a stamp but no modes; a plug-in ends with PALPA_MODES(…)");

  std::vector<Mode> modes;
  ModeCatalog all = catalog;
  std::string type;
  try {
    give_modes(modes);
    for (Mode& mode : modes) {
      type = mode.type();
      if (all.find(type)) file.refuse("brings the mode type '" + type + "', which is there already; give it another name");
      all.add(std::move(mode));
    }
  } catch (const LoadError&) {
    throw;
  } catch (const std::exception& error) {
    file.refuse(std::string("cannot make its modes (") + error.what() + "); repair it");
  }
  catalog = std::move(all);
}

detail::PluginAbi detail::library_abi() noexcept { return plugin_abi(); }

ModeCatalog modes_with(const std::vector<fs::path>& plugins) {
  ModeCatalog catalog = standard_modes();
  for (const fs::path& plugin : plugins) load_plugin(plugin, catalog);
  return catalog;
}

}  // namespace palpa
