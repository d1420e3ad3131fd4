// Opened and written files, among files by any other program.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/base/mapped_file.h"
#include "palpa/base/new_file.h"

namespace palpa::detail {
namespace disk_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Disk : public testing::Test {
 protected:
  Disk() {
    std::string name = (fs::temp_directory_path() / "palpa-disk-test-XXXXXX").string();
    folder = ::mkdtemp(name.data());
  }
  ~Disk() override { fs::remove_all(folder); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  static std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// The folder's names, hidden names included.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path().filename().string());
    std::sort(all.begin(), all.end());
    return all;
  }
  static std::string error_of(const std::function<void()>& what) {
    try {
      what();
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
  /// Runs this in a process of its own; returns its exit status, or 128 + its signal.
  static int in_child(const std::function<int()>& what) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(what());
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  fs::path folder;
};

using InputFiles = Disk;

TEST_F(InputFiles, OnlyOrdinaryOnesAreOpenedAndNoneIsWaitedFor) {
  EXPECT_TRUE(InputFile(write("a", "12")).is_open());
  EXPECT_EQ(InputFile(folder / "none").why_not(), NoInput::missing);
  EXPECT_EQ(InputFile(folder / "a" / "b").why_not(), NoInput::missing);
  EXPECT_EQ(InputFile(folder).why_not(), NoInput::folder);
  EXPECT_EQ(InputFile("/dev/zero").why_not(), NoInput::special);
  const fs::path pipe = folder / "pipe", socket = folder / "socket";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(InputFile(pipe).why_not(), NoInput::special);
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(InputFile(socket).why_not(), NoInput::special);
  ::close(listening);
  fs::create_symlink("loop", folder / "loop");
  EXPECT_EQ(InputFile(folder / "loop").why_not(), NoInput::unreadable);
  EXPECT_THAT(error_of([&] { InputFile(pipe).expect_open("name a file"); }),
              testing::MatchesRegex(".*/pipe: is no ordinary file.*; name a file"));
}

TEST_F(InputFiles, EndWhereTheyEndedWhenTheyWereOpened) {
  const fs::path path = write("a", "0123456789");
  const InputFile file(path);
  std::ofstream(path, std::ios::app) << "and more";
  char bytes[32] = {};
  EXPECT_EQ(file.read(0, bytes, sizeof bytes), 10U);
  EXPECT_EQ(file.read(8, bytes, sizeof bytes), 2U);
  EXPECT_EQ(std::string(bytes, 2), "89");
  EXPECT_EQ(file.read(10, bytes, 1), 0U);
  EXPECT_EQ(file.read(UINT64_MAX, bytes, 1), 0U);
  fs::resize_file(path, 4);
  EXPECT_EQ(file.read(0, bytes, sizeof bytes), 4U);
}

TEST_F(InputFiles, AreRefusedForTheirSizeBeforeTheyAreRead) {
  const fs::path path = write("a", "0123456789");
  const Limit ten_bytes{"ten", 10.0, "bytes", "a test", "it", "shorter"},
      nine_bytes{"nine", 9.0, "bytes", "a test", "it", "shorter"};
  EXPECT_EQ(read_whole(InputFile(path), ten_bytes, "shorter"), "0123456789");
  EXPECT_THAT(error_of([&] { read_whole(InputFile(path), nine_bytes, "shorter"); }), HasSubstr("longer than 9 bytes"));
  fs::resize_file(path, std::uintmax_t{1} << 40);  // without a byte on the disk
  EXPECT_THAT(error_of([&] { read_whole(InputFile(path), nine_bytes, "shorter"); }), HasSubstr("; shorter"));
}

TEST_F(InputFiles, AreStreamsToo) {
  std::string text;
  for (int line = 0; line < 30'000; ++line) text += std::to_string(line) + "\n";
  InputStream stream(write("a", text));
  std::string line;
  std::getline(stream, line);
  std::getline(stream, line);
  EXPECT_EQ(line, "1");
  EXPECT_EQ(stream.tellg(), 4);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), text.substr(4));
  stream.clear();
  stream.seekg(-6, std::ios::end);
  std::getline(stream, line);
  EXPECT_EQ(line, "29999");
  EXPECT_FALSE(InputStream(folder / "none"));
  EXPECT_FALSE(InputStream("/dev/zero"));
}

class NewFiles : public Disk, public testing::WithParamInterface<bool> {
 protected:
  /// Emulates a disk without unnamed files if the parameter requests it; irreversible, so in a process of its own.
  static void have_kind_of_disk() {
    if (!GetParam()) return;
    sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_openat, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
        BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, O_TMPFILE & ~O_DIRECTORY, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EOPNOTSUPP),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog program{static_cast<unsigned short>(std::size(filter)), filter};
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
      ::_exit(99);
  }
  static int on_disk(const std::function<int()>& what) {
    return in_child([&] {
      have_kind_of_disk();
      return what();
    });
  }
  void expect_refused(const fs::path& name, Existing existing, const std::string& words) const {
    EXPECT_EQ(on_disk([&] {
                const std::string error = error_of([&] { write_whole(name, "new", existing); });
                if (error.starts_with(name.string() + ": " + words)) return 0;
                std::fprintf(stderr, "%s\n", error.c_str());
                return 1;
              }),
              0);
  }
};

INSTANTIATE_TEST_SUITE_P(OnEveryDisk, NewFiles, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "WithAHiddenName" : "WithoutAName"; });

TEST_P(NewFiles, HaveTheirNameWhenTheyAreWhole) {
  EXPECT_EQ(on_disk([&] {
              NewFile file(folder / "a", Existing::refused);
              file.write("one ");
              const bool seen_early = fs::exists(folder / "a") || (GetParam() ? names().size() != 1 : !names().empty());
              file.write("two");
              file.finish();
              return seen_early ? 1 : 0;
            }),
            0);
  EXPECT_EQ(read(folder / "a"), "one two");
  EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_P(NewFiles, HaveTheRightsThatTheUserGivesToNewFiles) {
  on_disk([&] {
    ::umask(027);
    write_whole(folder / "a", "", Existing::refused);
    return 0;
  });
  EXPECT_EQ(fs::status(folder / "a").permissions(), fs::perms(0640));
}

TEST_P(NewFiles, ReplaceNothingUnasked) {
  write("a", "old");
  expect_refused(folder / "a", Existing::refused, "exists already");
  EXPECT_EQ(read(folder / "a"), "old");
  EXPECT_EQ(on_disk([&] { return write_whole(folder / "a", "new", Existing::replaced), 0; }), 0);
  EXPECT_EQ(read(folder / "a"), "new");
  EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_P(NewFiles, DoNotTakeANameThatSomebodyHasTakenMeanwhile) {
  EXPECT_EQ(on_disk([&] {
              NewFile file(folder / "a", Existing::refused);
              write("a", "theirs");
              return error_of([&] { file.finish(); }).starts_with("exists already") ? 0 : 1;
            }),
            0);
  EXPECT_EQ(read(folder / "a"), "theirs");
  EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_P(NewFiles, AreNeverWrittenThroughALinkOrIntoAPipe) {
  write("victim", "precious");
  fs::create_symlink("victim", folder / "link");
  fs::create_symlink("nowhere", folder / "dangling");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const char* name : {"link", "dangling", "pipe"}) {
    expect_refused(folder / name, Existing::refused, "exists already");
    expect_refused(folder / name, Existing::replaced, "cannot be written: it is a link");
  }
  expect_refused(folder, Existing::replaced, "cannot be written");
  expect_refused(folder / "no" / "folder", Existing::replaced, "cannot be written");
  EXPECT_EQ(read(folder / "victim"), "precious");
  EXPECT_THAT(names(), ElementsAre("dangling", "link", "pipe", "victim"));
  // A hard link is no followed link: the other name keeps the old bytes.
  fs::create_hard_link(folder / "victim", folder / "second");
  EXPECT_EQ(on_disk([&] { return write_whole(folder / "second", "new", Existing::replaced), 0; }), 0);
  EXPECT_EQ(read(folder / "victim"), "precious");
}

TEST_P(NewFiles, LeaveNothingOnAFullDisk) {
  write("old", "old");
  const auto fill = [&](const char* name) {
    return on_disk([&] {
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit most{1000, 1000};
      ::setrlimit(RLIMIT_FSIZE, &most);
      const std::string said = error_of([&] { write_whole(folder / name, std::string(5000, 'x'), Existing::replaced); });
      return said.find("make room") != std::string::npos ? 0 : 1;
    });
  };
  EXPECT_EQ(fill("a"), 0);
  EXPECT_EQ(fill("old"), 0);
  EXPECT_EQ(read(folder / "old"), "old");
  EXPECT_THAT(names(), ElementsAre("old"));
}

TEST_P(NewFiles, AreGoneWithTheProcess) {
  if (GetParam()) GTEST_SKIP() << "a disk without nameless files keeps a hidden one after kill -9";
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGSEGV, SIGKILL}) {
    EXPECT_EQ(on_disk([&] {
                NewFile file(folder / "a", Existing::refused);
                file.write(std::string(100'000, 'x'));
                const rlimit none{0, 0};
                ::setrlimit(RLIMIT_CORE, &none);
                ::signal(signal, SIG_DFL);
                return ::raise(signal);
              }),
              128 + signal);
    EXPECT_THAT(names(), IsEmpty()) << signal;
  }
}

using MappedFiles = Disk;

TEST_F(MappedFiles, ReadAsZerosWhereTheyWereCutShort) {
  const std::size_t page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const fs::path path = write("a", std::string(8 * page, 'x'));
  const MappedFile file{InputFile(path)};
  const MappedFile other{InputFile(write("b", std::string(8 * page, 'y')))};
  ASSERT_EQ(file.bytes(), 8 * page);
  const auto at = [&](const MappedFile& mapped, std::size_t place) { return static_cast<char>(mapped.data()[place]); };
  EXPECT_EQ(at(file, 8 * page - 1), 'x');
  EXPECT_TRUE(file.is_whole());
  fs::resize_file(path, 2 * page);
  EXPECT_EQ(at(file, 5 * page), '\0');
  EXPECT_EQ(at(file, 2 * page), '\0') << "in front of what was lost first";
  EXPECT_EQ(at(file, 2 * page - 1), 'x');
  EXPECT_FALSE(file.is_whole());
  EXPECT_EQ(at(other, 5 * page), 'y');
  EXPECT_TRUE(other.is_whole());
}

TEST_F(MappedFiles, NoticeALossWithinTheLastPage) {
  const fs::path path = write("a", std::string(100, 'x'));
  const MappedFile file{InputFile(path)};
  fs::resize_file(path, 50);
  EXPECT_FALSE(file.is_whole());
}

TEST_F(MappedFiles, LeaveOtherSignalsOfTheKindAlone) {
  const fs::path path = write("a", std::string(100, 'x'));
  const auto ends_by_itself = [&](bool sent) {
    return in_child([&]() -> int {
      const MappedFile file{InputFile(path)};
      const rlimit none{0, 0};
      ::setrlimit(RLIMIT_CORE, &none);
      if (sent) return ::raise(SIGBUS);
      const int foreign = ::open((folder / "b").c_str(), O_RDWR | O_CREAT, 0600);
      if (::ftruncate(foreign, 4096) != 0) return 1;
      const auto* memory = static_cast<const volatile char*>(::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, foreign, 0));
      if (::ftruncate(foreign, 0) != 0) return 1;
      return memory[0];
    });
  };
  EXPECT_EQ(ends_by_itself(true), 128 + SIGBUS);
  EXPECT_EQ(ends_by_itself(false), 128 + SIGBUS);
}

TEST_F(MappedFiles, ThatAreEmptyAreSoInMemory) {
  const MappedFile file{InputFile(write("a", ""))};
  EXPECT_EQ(file.bytes(), 0U);
  EXPECT_TRUE(file.is_whole());
}

}  // namespace disk_test
}  // namespace palpa::detail
