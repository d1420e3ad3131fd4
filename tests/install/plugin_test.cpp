// Plug-ins: loaded modes, and one-line refusals before any of their code runs.
#include "palpa/mode/plugin.h"

#include <elf.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "../app/program.h"
#include "palpa/palpa.h"

namespace palpa {
namespace plugin_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

/// The reason of a refusal; empty: accepted.
std::string refusal(const fs::path& file, ModeCatalog& catalog) {
  try {
    load_plugin(file, catalog);
  } catch (const LoadError& error) {
    return error.what();
  }
  return {};
}
std::string refusal(const fs::path& file) {
  ModeCatalog catalog = standard_modes();
  const std::string text = refusal(file, catalog);
  if (!text.empty()) {
    EXPECT_EQ(catalog.modes().size(), standard_modes().modes().size()) << text;
  }
  return text;
}

class Plugin : public ProgramTest {
 protected:
  const fs::path good = PALPA_PLUGIN_GOOD;

  void SetUp() override { ::unsetenv("PALPA_TEST_PLUGIN_RAN"); }
  bool ran() const { return std::getenv("PALPA_TEST_PLUGIN_RAN") != nullptr; }

  std::string bytes_of(const fs::path& file) const {
    std::ifstream in(file, std::ios::binary);
    EXPECT_TRUE(in) << file;
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// A file in the test's folder with these bytes.
  fs::path file_of(const std::string& bytes, const std::string& name = "changed.so") const {
    std::ofstream(folder / name, std::ios::binary | std::ios::trunc) << bytes;
    return folder / name;
  }
  /// The good plug-in with one number exchanged.
  template <class T>
  fs::path changed(std::size_t at, T value) const {
    std::string bytes = bytes_of(good);
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return file_of(bytes);
  }
  /// Offset of the stamp's note in the good plug-in.
  std::size_t stamp_at() const {
    const detail::PluginStamp stamp = detail::plugin_stamp(detail::plugin_abi());
    const std::string bytes = bytes_of(good);
    const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&stamp), sizeof stamp));
    EXPECT_NE(at, std::string::npos);
    return at;
  }
  std::size_t abi_at() const { return stamp_at() + offsetof(detail::PluginStamp, abi); }
};

TEST_F(Plugin, OfAnotherVersionIsRefusedBeforeItRuns) {
  const detail::PluginAbi own = detail::plugin_abi();
  const std::string own_version = std::to_string(own.major) + "." + std::to_string(own.minor);
  EXPECT_THAT(std::string(version), StartsWith(own_version + "."));

  const std::string minor = refusal(changed(abi_at() + 4, own.minor + 1));
  EXPECT_THAT(minor, EndsWith("changed.so: is made for palpa " + std::to_string(own.major) + "." +
                              std::to_string(own.minor + 1) + ", this is palpa " + own_version + "; rebuild it"));
  EXPECT_THAT(refusal(changed(abi_at(), own.major + 7)), HasSubstr("is made for palpa " + std::to_string(own.major + 7)));
  EXPECT_THAT(refusal(changed(abi_at() + 8, own.layout + 1)), AllOf(HasSubstr("other headers"), HasSubstr("changes.md")));
  EXPECT_FALSE(ran());
}

TEST_F(Plugin, BringsItsModes) {
  ModeCatalog catalog = standard_modes();
  EXPECT_EQ(catalog.find("lab.ridge"), nullptr);
  EXPECT_EQ(refusal(good, catalog), "");
  EXPECT_TRUE(ran());
  ASSERT_NE(catalog.find("lab.ridge"), nullptr);
  EXPECT_EQ(catalog.modes().size(), standard_modes().modes().size() + 1);
  EXPECT_NE(modes_with({good}).find("lab.ridge"), nullptr);
  EXPECT_EQ(standard_modes().find("lab.ridge"), nullptr) << "a catalog is a value";

  EXPECT_THAT(refusal(good, catalog), HasSubstr("brings the mode type 'lab.ridge', which is there already; "));
}

TEST_F(Plugin, IsAFileOfTheCurrentFolderWhereItsPathHasNoSlash) {
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  EXPECT_THAT(refusal("libc.so.6"), StartsWith("libc.so.6: no such file; "));
  fs::copy_file(good, "here.so");
  EXPECT_EQ(refusal("here.so"), "");
  fs::current_path(before);
}

TEST_F(Plugin, ThatIsNone) {
  EXPECT_THAT(refusal(folder / "nowhere.so"), HasSubstr("nowhere.so: no such file; "));
  EXPECT_THAT(refusal(file_of("") / "within"), HasSubstr("no such file; "));
  EXPECT_THAT(refusal(PALPA_PLUGIN_NONE),
              HasSubstr("is a library or program, but no plug-in; a plug-in ends with PALPA_MODES"));
  EXPECT_THAT(refusal("/proc/self/exe"), HasSubstr("but no plug-in; "));
  EXPECT_THAT(refusal(folder), HasSubstr("is no file; "));
  EXPECT_THAT(refusal("/dev/zero"), HasSubstr("is no file; "));
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(refusal(folder / "fifo"), HasSubstr("is no file; "));
  EXPECT_THAT(refusal(file_of("")), HasSubstr("is no shared library; "));
  EXPECT_THAT(refusal(file_of("PALPA_MODES(Ridge)\n")), HasSubstr("is no shared library; "));
  EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_type), std::uint16_t{ET_REL})), HasSubstr("is no shared library; "));
  EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_machine), std::uint16_t{EM_RISCV})),
              HasSubstr("another kind of machine; "));
  EXPECT_THAT(refusal(changed(EI_CLASS, std::uint8_t{ELFCLASS32})), HasSubstr("another kind of machine; "));
  EXPECT_FALSE(ran());
}

TEST_F(Plugin, ThatCannotBeTaken) {
  EXPECT_THAT(refusal(PALPA_PLUGIN_MISSING),
              AllOf(HasSubstr("cannot be loaded (undefined symbol: "), HasSubstr("lab_table"), HasSubstr("; link it with")));
  EXPECT_THAT(refusal(PALPA_PLUGIN_TAKEN), HasSubstr("brings the mode type 'follow', which is there already; "));
  EXPECT_THAT(refusal(PALPA_PLUGIN_THROWS), HasSubstr("cannot make its modes (no table of constants); "));
}

TEST_F(Plugin, CutShortAnywhereIsRefusedBeforeItRuns) {
  const std::string bytes = bytes_of(good);
  const fs::path file = file_of(bytes);
  std::size_t damaged = 0;
  for (std::size_t length = bytes.size(); length-- > 0;) {
    fs::resize_file(file, length);
    const std::string text = refusal(file);
    ASSERT_THAT(text, HasSubstr(length < SELFMAG ? "is no shared library; " : "is a damaged shared library (cut short?); "))
        << length;
    ++damaged;
  }
  EXPECT_GT(damaged, 4000u);
  EXPECT_FALSE(ran());
}

TEST_F(Plugin, WithLyingNumbersIsRefusedBeforeItRuns) {
  constexpr std::uint64_t huge[] = {UINT64_MAX, UINT64_MAX - 8, std::uint64_t{1} << 63, std::uint64_t{1} << 40};
  const std::size_t segments = sizeof(Elf64_Ehdr);
  for (const std::uint64_t number : huge) {
    EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_phoff), number)), HasSubstr("damaged"));
    EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_shoff), number)), HasSubstr("damaged"));
    EXPECT_THAT(refusal(changed(segments + offsetof(Elf64_Phdr, p_offset), number)), HasSubstr("damaged"));
    EXPECT_THAT(refusal(changed(segments + offsetof(Elf64_Phdr, p_filesz), number)), HasSubstr("damaged"));
  }
  EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_phnum), std::uint16_t{0xffff})), HasSubstr("damaged"));
  EXPECT_THAT(refusal(changed(offsetof(Elf64_Ehdr, e_phentsize), std::uint16_t{1})), HasSubstr("damaged"));
  for (const std::uint32_t number : {0u, 7u, 0x7fffffffu, 0xfffffffdu, 0xffffffffu}) {
    EXPECT_THAT(refusal(changed(stamp_at(), number)), HasSubstr("no plug-in")) << number;
    EXPECT_THAT(refusal(changed(stamp_at() + 4, number)), HasSubstr("no plug-in")) << number;
  }

  // Without its stamp no change of the headers can make it a plug-in: all their readers must survive.
  std::string bytes = bytes_of(good);
  bytes[stamp_at() + offsetof(detail::PluginStamp, owner)] = 'P';
  std::mt19937 random(4);
  for (int i = 0; i < 4000; ++i) {
    std::string copy = bytes;
    for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
      copy[random() % 1024] = random() % 2 ? static_cast<char>(random()) : static_cast<char>(random() % 2 ? 0xff : 0);
    }
    ASSERT_THAT(refusal(file_of(copy)), MatchesRegex("[^\n]+: [^\n]+; [^\n]+"));
  }
  EXPECT_FALSE(ran());
}

TEST_F(Plugin, OnTheCommandLine) {
  const auto expect_refusal = [&](const std::vector<std::string>& arguments, const std::string& piece) {
    const Ended ended = palpa(arguments);
    EXPECT_EQ(ended.code, 2) << testing::PrintToString(arguments);
    EXPECT_EQ(ended.out, "");
    EXPECT_THAT(ended.err, AllOf(MatchesRegex("palpa: [^\n]*: [^\n]*; [^\n]*\n"), HasSubstr(piece)));
  };
  write("ridge.toml",
        "palpa = 1\nneeds = [\"lab.ridge\"]\n[volume.ball]\nanalytic = \"sphere\"\n"
        "[[mode]]\nname = \"ridge\"\ntype = \"lab.ridge\"\nfield = \"ball\"\n");
  const std::vector<std::string> run = {"run", "ridge.toml", "--hand", "sim:press", "--duration-s", "0.5"};
  const auto with = [](std::vector<std::string> arguments, const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  expect_refusal(run, "'lab.ridge'");
  expect_refusal(with(run, {"--plugin", PALPA_PLUGIN_NONE}), "no plug-in");
  expect_refusal(with(run, {"--plugin", PALPA_PLUGIN_MISSING}), "lab_table");
  expect_refusal(with(run, {"--plugin", good, "--plugin", good}), "there already");
  expect_refusal(with(run, {"--plugin", changed(abi_at() + 4, std::uint32_t{99})}), "is made for palpa");
  expect_refusal({"modes", "--plugin", "nowhere.so"}, "nowhere.so: no such file");
  EXPECT_FALSE(fs::exists(folder / "trace"));

  EXPECT_THAT(palpa({"modes", "--plugin", good}).out, HasSubstr("lab.ridge"));
  EXPECT_THAT(palpa({"modes", "lab.ridge", "--plugin", good}).out, HasSubstr("force that holds the hand"));
  EXPECT_EQ(palpa(with(run, {"--plugin", good, "--out", "trace"})).code, 0);
  EXPECT_THAT(read(folder / "trace" / "trace.toml"), HasSubstr("plugins = [\"" + good.string() + "\"]"));
  expect_refusal({"replay", "trace"}, "name it with --plugin");
  expect_refusal({"replay", "trace", "--plugin", PALPA_PLUGIN_NONE}, "no plug-in");
  EXPECT_EQ(palpa({"replay", "trace", "--plugin", good}).out, "identical in all 500 ticks\n");
}

}  // namespace plugin_test
}  // namespace palpa
