// The sandbox of a compromised reader; files that name others, or lie behind links.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/file/store_reader.h"

namespace palpa {
namespace cage_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

/// Two folders side by side: the reader's own, and the forbidden.
class Caged : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    fs::create_directories(inside());
    fs::create_directories(outside());
  }
  void TearDown() override {
    for (const char* name :
         {"ESCAPE", "CAGE", "INSIDE", "OUTSIDE", "PORT", "SECRET_AT", "KERNEL_WITHOUT", "REAL_READER", "PALPA_READER_FOLDERS"})
      ::unsetenv(name);
    fs::remove_all(folder_);
  }

  fs::path inside() const { return folder_ / "inside"; }
  fs::path outside() const { return folder_ / "outside"; }
  static fs::path write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  /// \param as_store  opens it for its chunks, by palpa-read-zarr
  static std::string error_of(const fs::path& file, const ReadOptions& options = {}, bool as_store = false) {
    try {
      if (as_store) {
        const StoreReader store(file, options, 1);
      } else {
        read_volume(file, options);
      }
    } catch (const LoadError& problem) {
      return problem.what();
    }
    return {};
  }

 private:
  fs::path folder_;
};

/// Of a reader of files, and of one that serves the chunks of a store.
class Escapes : public Caged, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    Caged::SetUp();
    lay_out();
    ::setenv("INSIDE", inside().c_str(), 1);
    ::setenv("OUTSIDE", outside().c_str(), 1);
    ::setenv("SECRET_AT", std::to_string(reinterpret_cast<std::uintptr_t>(secret_)).c_str(), 1);
    ::prctl(PR_SET_PTRACER, PR_SET_PTRACER_ANY);  // else the system itself protects the parent
    listen_on_tcp();
    listen_here();
  }
  void TearDown() override {
    for (const int file : {tcp_, here_}) ::close(file);
    ::prctl(PR_SET_PTRACER, 0);
    Caged::TearDown();
  }

  /// Result of an escape: "escaped; …", "refused: …" or the reader's end.
  /// \param cage  "none", "network": that of palpa-fetch; empty: the readers'
  std::string tried(const std::string& escape, const char* cage) {
    lay_out();
    ::setenv("ESCAPE", escape.c_str(), 1);
    ::setenv("CAGE", cage, 1);
    ReadOptions options;
    options.reader = ESCAPING_READER;
    const fs::path file = GetParam() ? inside() : inside() / "a.nrrd";
    // The reader gets this program's standard output, which is a file meanwhile.
    std::fflush(stdout);
    const int console = ::dup(STDOUT_FILENO), output = ::creat((outside() / "output").c_str(), 0600);
    ::dup2(output, STDOUT_FILENO);
    const std::string error = error_of(file, options, GetParam());
    ::dup2(console, STDOUT_FILENO);
    for (const int descriptor : {console, output}) ::close(descriptor);
    EXPECT_THAT(error, StartsWith(file.string() + ": "));
    return error.substr(std::min(error.size(), file.string().size() + 2));
  }
  bool ran() const { return fs::exists(outside() / "ran"); }
  const char* secret() const { return secret_; }

 private:
  void lay_out() {
    write(inside() / "a.nrrd", "any bytes");
    write(inside() / "victim", "whole");
    fs::permissions(inside() / "victim", fs::perms::owner_read | fs::perms::owner_write);
    write(outside() / "secret", "secret");
    std::memcpy(secret_, "kept", 5);
    for (const fs::path& made : {inside() / "made", inside() / "moved", inside() / "folder", inside() / "way",
                                 inside() / "link", outside() / "made", outside() / "ran"})
      fs::remove(made);
    fs::create_symlink("../outside/secret", inside() / "link");
  }
  void listen_on_tcp() {
    tcp_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET, at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    ASSERT_EQ(::bind(tcp_, reinterpret_cast<const sockaddr*>(&at), size), 0);
    ASSERT_EQ(::listen(tcp_, 8), 0);
    ASSERT_EQ(::getsockname(tcp_, reinterpret_cast<sockaddr*>(&at), &size), 0);
    ::setenv("PORT", std::to_string(ntohs(at.sin_port)).c_str(), 1);
  }
  void listen_here() {
    here_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::strncpy(at.sun_path, (outside() / "socket").c_str(), sizeof at.sun_path - 1);
    ASSERT_EQ(::bind(here_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    ASSERT_EQ(::listen(here_, 8), 0);
  }

  char secret_[5] = {};
  int tcp_ = -1, here_ = -1;
};

std::vector<std::string> lines_of(const std::string& command) {
  std::vector<std::string> lines;
  const std::unique_ptr<std::FILE, decltype(&::pclose)> output(::popen(command.c_str(), "r"), ::pclose);
  char line[256];
  while (output && std::fgets(line, sizeof line, output.get()) != nullptr) lines.emplace_back(line, std::strcspn(line, "\n"));
  return lines;
}

/// Escapes that only Landlock refuses.
bool needs_landlock(const std::string& escape) {
  return escape.find("read a file outside") == 0 || escape.find("list a folder") == 0 || escape.find("read by a ") == 0 ||
         escape == "read the parent's environment" || escape == "read the caller's memory as a file";
}

INSTANTIATE_TEST_SUITE_P(OfFilesAndStores, Escapes, testing::Bool());

TEST_P(Escapes, AreAllRefused) {
  const std::string lacking = tried("which parts are lacking?", "");
  if (lacking.find("sanitizer") != std::string::npos) GTEST_SKIP() << "this build has no cage: " << lacking;
  const std::vector<std::string> escapes = lines_of(std::string("'") + ESCAPING_READER + "' --list");
  EXPECT_GE(escapes.size(), 40u);
  int refused = 0;
  for (const std::string& escape : escapes) {
    if (lacking.find("seccomp") != std::string::npos ||
        (needs_landlock(escape) && lacking.find("Landlock") != std::string::npos)) {
      std::printf("not tried, because the kernel %s: %s\n", lacking.c_str(), escape.c_str());
      continue;
    }
    const std::string how = tried(escape, "");
    const bool ended = how.find("forbids") != std::string::npos;
    EXPECT_TRUE(ended || how.find("refused: ") == 0) << escape << ": " << how;
    EXPECT_FALSE(ran()) << escape;
    EXPECT_STREQ(secret(), "kept") << escape;
    std::printf("%-45s %s\n", escape.c_str(), how.c_str());
    ++refused;
  }
  std::printf("%d escapes refused\n", refused);
}

// palpa-fetch has a network and files in memory; all else is kept from it, too.
TEST_P(Escapes, AreRefusedWithANetwork) {
  const std::string lacking = tried("which parts are lacking?", "network");
  if (lacking.find("'lacks: '") == std::string::npos) GTEST_SKIP() << "not the whole cage: " << lacking;
  for (const std::string& escape : lines_of(std::string("'") + ESCAPING_READER + "' --list")) {
    const std::string how = tried(escape, "network");
    // The terminal's escape is tried by a harmless ioctl, which a query for a server's name needs.
    if (escape == "connect by TCP" || escape == "send by UDP" || escape == "make a file of memory" ||
        escape == "type into the terminal")
      continue;
    EXPECT_TRUE(how.find("forbids") != std::string::npos || how.find("refused: ") == 0) << escape << ": " << how;
    EXPECT_FALSE(ran()) << escape;
    EXPECT_STREQ(secret(), "kept") << escape;
  }
}

// Else the tests above could not fail.
TEST_P(Escapes, SucceedWithoutTheCage) {
  for (const std::string& escape : lines_of(std::string("'") + ESCAPING_READER + "' --list")) {
    const std::string how = tried(escape, "none");
    const bool became = escape.find("become a program") == 0;
    // Escapes that the system itself, or a container, prevents.
    const bool kept =
        how.find("refused: ") == 0 &&
        (escape.find("openat2") != std::string::npos || escape == "have the kernel call for it" ||
         escape == "take memory without end" || escape == "take a namespace of its own" || escape == "fork by clone3");
    if (kept) std::printf("refused without the cage, too: %s: %s\n", escape.c_str(), how.c_str());
    EXPECT_TRUE(kept || (became ? ran() : how == "escaped; nothing held it")) << escape << ": " << how;
  }
}

// Containers and older kernels lack parts: files are read in a partial sandbox.
TEST_F(Caged, IsClosedWithoutThePartsThatTheKernelLacks) {
  const fs::path reader = fs::path(PALPA_READERS) / "palpa-read";
  if (testing::Matches(testing::Contains(HasSubstr("sanitizer")))(lines_of("'" + reader.string() + "' --cage")))
    GTEST_SKIP() << "this build has no cage";
  const fs::path file =
      write(inside() / "a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nabcdefgh");
  ReadOptions options;
  options.reader = ESCAPING_READER;
  ::setenv("REAL_READER", reader.c_str(), 1);
  for (const char* part : {"Landlock", "seccomp"}) {
    ::setenv("KERNEL_WITHOUT", part, 1);
    EXPECT_EQ(error_of(file, options), "") << part;
    EXPECT_THAT(lines_of(std::string("'") + ESCAPING_READER + "' --cage"), testing::Contains(HasSubstr(part)));
  }
}

constexpr const char* header_of_others = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: ";

class Partners : public Caged {
 protected:
  void SetUp() override {
    Caged::SetUp();
    if (!lines_of("'" + (fs::path(PALPA_READERS) / "palpa-read").string() + "' --cage").empty())
      GTEST_SKIP() << "the kernel lacks a part of the cage, or this is a build with a sanitizer";
    options_.reader = fs::path(PALPA_READERS) / "palpa-read";
    write(outside() / "x.raw", "abcdefgh");
  }
  void expect_refused_until_named(const fs::path& file) {
    EXPECT_THAT(error_of(file, options_), HasSubstr("PALPA_READER_FOLDERS"));
    ::setenv("PALPA_READER_FOLDERS", ("/none:" + outside().string()).c_str(), 1);
    EXPECT_EQ(error_of(file, options_), "");
    ::unsetenv("PALPA_READER_FOLDERS");
  }
  ReadOptions options_;
};

TEST_F(Partners, BelowTheFolderOfTheirHeaderAreRead) {
  fs::create_directories(inside() / "below");
  write(inside() / "below" / "x.raw", "abcdefgh");
  EXPECT_EQ(error_of(write(inside() / "a.nhdr", header_of_others + std::string("below/x.raw\n")), options_), "");
}

TEST_F(Partners, ElsewhereAreReadWhereTheirFolderIsNamed) {
  expect_refused_until_named(write(inside() / "a.nhdr", header_of_others + std::string("../outside/x.raw\n")));
  expect_refused_until_named(write(inside() / "b.nhdr", header_of_others + (outside() / "x.raw").string() + "\n"));
  expect_refused_until_named(
      write(inside() / "a.mhd",
            "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = ../outside/x.raw\n"));
}

TEST_F(Partners, BehindALinkAreReadWhereTheirFolderIsNamed) {
  fs::create_symlink("../outside/x.raw", inside() / "x.raw");
  expect_refused_until_named(write(inside() / "a.nhdr", header_of_others + std::string("x.raw\n")));
}

TEST_F(Partners, OfALinkedHeaderAreReadBesideIt) {
  write(outside() / "a.nhdr", header_of_others + std::string("x.raw\n"));
  fs::create_symlink("../outside/a.nhdr", inside() / "a.nhdr");
  fs::create_symlink("../outside/x.raw", inside() / "x.raw");
  EXPECT_EQ(error_of(inside() / "a.nhdr", options_), "");
}

// A missing slice would give another volume.
TEST_F(Partners, OfAFolderAreNotPassedOver) {
  fs::create_symlink("../outside/x.raw", inside() / "x.dcm");
  EXPECT_THAT(error_of(inside(), options_), HasSubstr("x.dcm', which lies outside"));
}

}  // namespace cage_test
}  // namespace palpa
