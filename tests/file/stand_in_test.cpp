// A volume or a one-line error from any reader, without leaks and hangs.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stop_token>
#include <thread>

#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/file/store_reader.h"

namespace palpa {
namespace stand_in_test {

namespace fs = std::filesystem;

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

class StandIn : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    file_ = write("a.nrrd", "any bytes");
    options_.reader = STAND_IN_READER;
    options_.idle_limit_s = 0.5;
    descriptors_ = open_descriptors();
  }
  void TearDown() override {
    EXPECT_EQ(open_descriptors(), descriptors_);
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
    ::unsetenv("STAND_IN");
    ::unsetenv("PALPA_READER");
    fs::remove_all(folder_);
  }

  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name) << bytes;
    return folder_ / name;
  }

  Volume read() { return read_volume(file_, options_); }

  /// The error, without the file's name.
  std::string error(const char* part) {
    ::setenv("STAND_IN", part, 1);
    try {
      read();
    } catch (const LoadError& problem) {
      const std::string text = problem.what();
      EXPECT_EQ(text.rfind(file_.string() + ": ", 0), 0U) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      EXPECT_NE(text.find("; "), std::string::npos) << text;
      return text.substr(file_.string().size() + 2);
    }
    ADD_FAILURE() << "no error";
    return {};
  }
  /// Of a reader that computes for ever: on a busy machine it may compute too little to be found out by that.
  static void expect_either(const std::string& text, const std::string& of, const std::string& or_of) {
    EXPECT_TRUE(text.find(of) != std::string::npos || text.find(or_of) != std::string::npos) << text;
  }
  void expect_error(const char* part, const std::string& of) {
    const std::string text = error(part);
    EXPECT_NE(text.find(of), std::string::npos) << part << ": " << text;
  }

  fs::path folder_, file_;
  ReadOptions options_;

 private:
  std::size_t descriptors_ = 0;
};

TEST_F(StandIn, AWellBehavedReaderGivesAVolumeThatStays) {
  Volume volume = read();
  ASSERT_EQ(volume.fields.size(), 1U);
  EXPECT_NEAR(volume.fields[0].field->scalar({1e-3, 1e-3, 1e-3}).value, 21.0, 1e-9);
  EXPECT_EQ(volume.fields[0].field->value_ranges()[0].max, 63.0);
  EXPECT_EQ(volume.files[0].path, "a file");
  EXPECT_EQ(volume.warnings.back(), "a late warning");
  ::setenv("STAND_IN", "stay", 1);
  EXPECT_NEAR(read().fields[0].field->scalar({1e-3, 1e-3, 1e-3}).value, 21.0, 1e-9);
}

TEST_F(StandIn, TheVolumeIsThereBeforeItsChecksums) {
  options_.checksums = Checksums::later;
  for (const auto& [part, text] : {std::pair("later", "00ff"), {"later ends", ""}, {"later hangs", ""}}) {
    ::setenv("STAND_IN", part, 1);
    const Volume volume = read();
    EXPECT_EQ(volume.files[0].path, "a file");
    EXPECT_EQ(std::ranges::count(volume.warnings, "a late warning"), 1);
    EXPECT_EQ(volume.files[0].sha256.text(), text) << part;
    EXPECT_TRUE(volume.files[0].sha256.is_known());
    EXPECT_NEAR(volume.fields[0].field->scalar({1e-3, 1e-3, 1e-3}).value, 21.0, 1e-9);
  }
}

TEST_F(StandIn, NoReaderThatGoesOnCanWriteTheVoxels) {
  options_.checksums = Checksums::later;
  options_.idle_limit_s = 1000.0;
  expect_error("stay", "cannot be sealed");
}

TEST_F(StandIn, ChecksumsEndWithTheVolume) {
  options_.checksums = Checksums::later;
  options_.idle_limit_s = 1000.0;
  ::setenv("STAND_IN", "later hangs", 1);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(read().files[0].sha256.is_known());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
}

class StoreStandIn : public StandIn {
 protected:
  /// Reads two chunks of a store that its reader serves so; returns the error, without the file's name.
  std::string store_error(const char* part) {
    ::setenv("STAND_IN", part, 1);
    try {
      StoreReader store(file_, options_, 4);
      store.request({}, 0);
      for (int n = 0; n < 100; ++n) {
        if (const auto read = store.next(0.1)) sentence_ = read->sentence;
      }
    } catch (const LoadError& problem) {
      const std::string text = problem.what();
      EXPECT_EQ(text.rfind(file_.string() + ": ", 0), 0U) << text;
      EXPECT_NE(text.find("; "), std::string::npos) << text;
      return text.substr(file_.string().size() + 2);
    }
    return {};
  }
  void expect_store_error(const char* part, const std::string& of) {
    const std::string text = store_error(part);
    EXPECT_NE(text.find(of), std::string::npos) << part << ": " << text;
  }
  std::string sentence_;
};

TEST_F(StoreStandIn, AWellBehavedReaderFillsSlotsAsLongAsItIsAsked) {
  StoreReader store(file_, options_, 3);
  EXPECT_EQ(store.contents().format, "stand-in");
  for (int n = 1; n < 50; ++n) {
    store.request({.at = {1, 0, 1}}, n % 3);
    const auto read = store.next(10.0);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->bytes, 64U);
    EXPECT_EQ(store.content(n % 3).size(), 64U);
    EXPECT_EQ(static_cast<int>(store.content(n % 3)[63]), n);
  }
}

TEST_F(StoreStandIn, ReadersThatSayWhatCannotBe) {
  expect_store_error("huge store", "has an octave of no voxel, or of more than 262144, along an axis");
  expect_store_error("no field of a store", "has no field, or more than 256");
  for (const char* part : {"unasked chunk", "another slot", "slot beyond", "another chunk", "two answers", "wrong turn"})
    expect_store_error(part, "answered out of turn");
  expect_store_error("nonsense", "does not speak as this program does");
  expect_store_error("failure", "is not liked; bring another");
  expect_store_error("refuse a chunk", "has enough; ask no more");
  EXPECT_EQ(store_error("words"), "");
  EXPECT_LE(sentence_.size(), 2000U);
  EXPECT_EQ(sentence_.find_first_of("\n\x9b"), std::string::npos);
}

TEST_F(StoreStandIn, ReadersThatEndOrGoOnForEver) {
  expect_store_error("exit at once", "code 7");
  expect_store_error("killed with a chunk", "signal 9");
  expect_store_error("hang with a chunk", "made no progress for 0.5 s");
  expect_either(store_error("spin with a chunk"), "computed for 0.5 s without reading on", "finished no chunk for 3 s");
  EXPECT_EQ(store_error("shrink"), "");  // which the seal refuses
}

TEST_F(StandIn, ReadersThatEndEarly) {
  expect_error("exit at once", "code 7");
  expect_error("abort at once", "signal 6");
  expect_error("killed in the middle", "signal 9");
  expect_error("segfault in the middle", "signal 11");
  expect_error("exit in the middle", "code 0");
  expect_error("close and stay", "before it was done");
}

TEST_F(StandIn, ReadersThatMakeNoProgress) {
  expect_error("hang at once", "no progress for 0.5 s");
  expect_error("hang in the middle", "no progress for 0.5 s");
  expect_either(error("spin in the middle"), "without reading on", "no progress for 0.5 s");
}

TEST_F(StandIn, ReadersThatStartTooManyThreads) { expect_error("too many threads", "more than 2048 threads"); }

TEST_F(StandIn, ReadersThatTryWhatTheirCageForbids) { expect_error("forbidden", "what its cage forbids"); }

TEST_F(StandIn, AReaderIsEndedWhenItsCallerNoLongerWantsTheFile) {
  options_.idle_limit_s = 60.0;
  for (const char* part : {"hang at once", "hang in the middle", "spin in the middle"}) {
    std::stop_source source;
    options_.stop = source.get_token();
    std::thread person([&source] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      source.request_stop();
    });
    expect_error(part, "cancelled");
    person.join();
  }
}

TEST_F(StandIn, ReadersThatTalkNonsense) {
  expect_error("nonsense", "does not speak as this program does");
  expect_error("wrong turn", "out of turn");
  expect_error("header again", "out of turn");
  EXPECT_EQ(error("failure"), "is not liked; bring another");
}

TEST_F(StandIn, WhatReadersSaySteersNothing) {
  const std::string text = error("no sentence");
  EXPECT_EQ(text, detail::sanitized(text));
  EXPECT_NE(text.find("is not liked'; "), std::string::npos) << text;
  EXPECT_LE(error("long sentence").size(), 2000U);
  file_ = write("a\u202e\x1b.nrrd", "any bytes");
  ::setenv("STAND_IN", "failure", 1);
  try {
    read();
    ADD_FAILURE() << "no error";
  } catch (const LoadError& problem) {
    EXPECT_EQ(std::string(problem.what()), detail::sanitized(problem.what())) << "the name of a file steers nothing either";
  }
}

TEST_F(StandIn, HeadersThatCannotBe) {
  expect_error("no fields", "no field");
  expect_error("too large", "claims 1000000 × 1000000 × 1000000 voxels");
  expect_error("much too large", "more voxels than can be counted");
  expect_error("hungry", "free; crop or downsample");
  expect_error("flat", "cannot be placed in the world");
  expect_error("no number", "cannot be placed in the world");
  expect_error("no scale", "factor that is zero");
}

TEST_F(StandIn, SharedMemoryCannotBeTakenAway) {
  ::setenv("STAND_IN", "shrink", 1);
  EXPECT_NO_THROW(read());
}

TEST_F(StandIn, ScriptsAreEndedWithWhatTheyStarted) {
  const fs::path script = write("sleeper", "#!/bin/sh\nsleep 600 &\nsleep 600\n");
  fs::permissions(script, fs::perms::owner_all);
  options_.reader = script;
  expect_error("", "no progress for 0.5 s");
}

TEST_F(StandIn, ReadersThatAreNotThere) {
  options_.reader = folder_ / "none";
  expect_error("", "is no program");
  options_.reader = file_;  // not executable
  expect_error("", "is no program");
  options_.reader.clear();
  ::setenv("PALPA_READER", "/none", 1);
  expect_error("", "PALPA_READER is '/none'");
  ::unsetenv("PALPA_READER");
  if (!fs::exists(fs::read_symlink("/proc/self/exe").parent_path() / "palpa-read")) expect_error("", "not beside this one");
  const fs::path broken = write("broken", "no program");
  fs::permissions(broken, fs::perms::owner_all);
  options_.reader = broken;
  expect_error("", "does not start");
}

TEST_F(StandIn, TheEnvironmentNamesAReader) {
  options_.reader.clear();
  ::setenv("PALPA_READER", STAND_IN_READER, 1);
  EXPECT_NO_THROW(read());
}

TEST_F(StandIn, NoReaderIsStartedForWhatIsNoFile) {
  options_.reader = "/none";
  const auto what = [&](const fs::path& path) -> std::string {
    try {
      read_volume(path, options_);
    } catch (const LoadError& problem) {
      return problem.what();
    }
    return {};
  };
  EXPECT_NE(what(folder_ / "missing").find("does not exist"), std::string::npos);
  EXPECT_NE(what(folder_).find("no program"), std::string::npos);  // folders are up to the reader
  EXPECT_NE(what(write("empty", "")).find("is empty"), std::string::npos);
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(what(pipe).find("no ordinary file"), std::string::npos);
}

}  // namespace stand_in_test
}  // namespace palpa
