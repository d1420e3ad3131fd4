// The program on a failing machine: killed, out of disk, descriptors or memory, without write permission, under odd file names.
// Required: an end, a one-line error, and output that is complete or marked as incomplete.
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "palpa/base/utf8.h"
#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/program.h"

namespace palpa::fuzz {
namespace {

constexpr ::uid_t nobody = 65534;

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// ---- work ----

/// A command of the program, and its output in its working folder.
struct Work {
  std::vector<std::string> arguments;
  std::string makes{};
};

/// Inputs of all commands: a scene, a hand, a file of voxels, a trace. Made once, then read-only.
class Given {
 public:
  explicit Given(const fs::path& folder) : folder_(folder) {
    std::ofstream(folder_ / "scene.toml")
        << "palpa = 1\n[volume.head]\nanalytic = \"head_phantom\"\n[workspace]\nfit = \"head\"\n"
           "towards_user = \"anterior\"\nup = \"superior\"\n[[mode]]\nname = \"skin\"\n"
           "type = \"surface_and_friction\"\nfield = \"head\"\n[[mode.level]]\nvalue = -300\n";
    std::ofstream hand(folder_ / "hand.csv");
    hand << "t_s,x_m,y_m,z_m\n";
    for (int n = 0; n < 600; ++n) hand << 0.005 * n << ',' << 0.02 * std::sin(0.02 * n) << ",0.01," << 0.075 << '\n';
    hand.close();
    std::ofstream nrrd(folder_ / "ball.nrrd", std::ios::binary);
    nrrd << "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nspacings: 5 5 5\nencoding: raw\n\n";
    for (int k = -12; k < 12; ++k)
      for (int j = -12; j < 12; ++j)
        for (int i = -12; i < 12; ++i) nrrd.put(static_cast<char>(std::clamp(200 - 2 * (i * i + j * j + k * k), 0, 200)));
    nrrd.close();
    const Ended run = ended(
        {.program = programs_folder() / "palpa",
         .arguments = {"run", "scene.toml", "--hand", "hand.csv", "--hand-fit", "off", "--duration-s", "0.5", "--out", "trace"},
         .folder = folder_});
    if (run.code != 0) throw std::runtime_error("the work cannot be done without a fault: " + run.err);
    for (const fs::path& path : {folder_, folder_.parent_path()}) fs::permissions(path, fs::perms(0755));
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
      fs::permissions(entry.path(), entry.is_directory() ? fs::perms(0755) : fs::perms(0644));
  }

  /// \param from  folder of scene, hand, file and trace
  Work any_work(Choices& choices, const fs::path& from) const {
    const auto given = [&](const char* name) { return (from / name).string(); };
    switch (choices.below(12)) {
      case 0:
      case 1: return {{"info", given("ball.nrrd"), "--json"}};
      case 2: return {{"info", given("ball.nrrd"), "--scene", "first.toml"}, "first.toml"};
      case 3:
      case 4: return {{"convert", given("ball.nrrd"), "out.vti"}, "out.vti"};
      case 5: return {{"convert", given("ball.nrrd"), "out.nrrd"}, "out.nrrd"};
      case 6:
      case 7: return {{"replay", given("trace")}};
      case 8: return {{"report", given("trace"), "--out", "page.html"}, "page.html"};
      default:
        return {{"run", given("scene.toml"), "--hand", given("hand.csv"), "--hand-fit", "off", "--duration-s", "3",
                 "--primitives", "--out", "out"},
                "out"};
    }
  }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

Start start_of(const Work& work, const fs::path& folder) {
  return {.program = programs_folder() / "palpa", .arguments = work.arguments, .folder = folder, .patience_s = 60.0 * slowness};
}

/// Checks that output is complete or marked as incomplete.
std::string broken_by_rest(const Work& work, const fs::path& folder, const Ended& run) {
  const fs::path made = folder / work.makes;
  if (work.makes.empty() || !fs::exists(made)) return run.code == 0 && !work.makes.empty() ? "what ends well was made" : "";
  const auto said = [&] { return ": " + work.makes + ", exit code " + std::to_string(run.code); };
  const fs::path aside = folder.parent_path();
  if (work.makes == "out") {
    const bool is_complete = content(made / "trace.toml").find("complete = true") != std::string::npos;
    if ((run.code == 0) != is_complete && run.code < 128)
      return "a trace is complete if and only if its run ended well" + said();
    const Ended replay =
        ended({.program = programs_folder() / "palpa", .arguments = {"replay", made.string()}, .folder = aside});
    if (replay.code == 1) return "a trace that began replays to the bit: " + replay.out.substr(0, 200);
    if (is_complete && replay.code != 0) return "a whole trace can be replayed" + said();
    return broken_by_run(replay, true);
  }
  if (work.makes == "page.html")
    return content(made).find("</html>") == std::string::npos ? "what has its name is whole" + said() : "";
  const bool is_scene = work.makes == "first.toml";
  const Ended look =
      ended({.program = programs_folder() / "palpa",
             .arguments = is_scene ? std::vector<std::string>{"run", made.string(), "--hand", "sim:press", "--dry-run"}
                                   : std::vector<std::string>{"info", made.string()},
             .folder = aside});
  return look.code == 0 ? "" : "what has its name is whole" + said() + ": " + look.err.substr(0, 200);
}

std::string broken_by_litter(const Work& work, const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name != work.makes && name != "lost+found") return "no temporary file is left: " + name;
  }
  return {};
}

std::string broken_by_end(const Work& work, const fs::path& folder, const Ended& run) {
  std::string broken = broken_by_run(run, work.arguments[0] == "replay");
  if (broken.empty()) broken = broken_by_rest(work, folder, run);
  if (broken.empty()) broken = broken_by_litter(work, folder);
  return broken.empty() ? broken : broken + " (palpa " + work.arguments[0] + ")";
}

Tried tried(const Ended& run, std::string broken) {
  return {.broken = std::move(broken), .slowest_s = run.spent_s, .refused = run.code == 2};
}

// ---- faults ----

Tried ended_by(int signal, const Given& given, Choices& choices, const fs::path& folder) {
  const Work work = given.any_work(choices, given.folder());
  const double moment_s = choices.log_between(1e-4, 1.0);
  Start start = start_of(work, folder);
  start.meanwhile = [&](pid_t process) {
    std::this_thread::sleep_for(std::chrono::duration<double>(moment_s));
    ::kill(process, signal);
  };
  const Ended run = ended(start);
  if (run.code != 128 + signal) return tried(run, broken_by_end(work, folder, run));
  std::string broken = broken_by_rest(work, folder, run);
  // SIGKILL leaves no time for cleanup.
  if (broken.empty() && signal != SIGKILL) broken = broken_by_litter(work, folder);
  return tried(run, broken.empty() ? broken : broken + " (palpa " + work.arguments[0] + ")");
}

Tried limited(const std::function<void()>& limit, const Given& given, Choices& choices, const fs::path& folder) {
  const Work work = given.any_work(choices, given.folder());
  Start start = start_of(work, folder);
  start.before = limit;
  const Ended run = ended(start);
  // Before the program's start the system's loader may fail, in its own words.
  if (run.code == 127 || run.err.find("error while loading shared libraries") != std::string::npos) return tried(run, {});
  return tried(run, broken_by_end(work, folder, run));
}

void limit(decltype(RLIMIT_AS) resource, std::uint64_t most) {
  const rlimit to{most, most};
  ::setrlimit(resource, &to);
}

Tried without_descriptors(const Given& given, Choices& choices, const fs::path& folder) {
  const std::uint64_t most = 3 + choices.below(20);
  return limited([=] { limit(RLIMIT_NOFILE, most); }, given, choices, folder);
}

Tried without_memory(const Given& given, Choices& choices, const fs::path& folder) {
  const auto most = static_cast<std::uint64_t>(choices.log_between(2e7, 2e9));
  return limited([=] { limit(RLIMIT_AS, most); }, given, choices, folder);
}

/// A small disk of its own, which fills up.
class Disk {
 public:
  Disk(const fs::path& at, std::uint64_t bytes) : at_(at) {
    fs::create_directory(at_);
    const std::string size = "size=" + std::to_string(bytes);
    if (::mount("tmpfs", at_.c_str(), "tmpfs", 0, size.c_str()) != 0) throw std::runtime_error("no small disk can be mounted");
  }
  ~Disk() { ::umount2(at_.c_str(), MNT_DETACH); }
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  void make_read_only() const { ::mount("tmpfs", at_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr); }

 private:
  fs::path at_;
};

Tried on_full_disk(const Given& given, Choices& choices, const fs::path& folder) {
  const Work work = given.any_work(choices, given.folder());
  const Disk disk(folder / "disk", 4096 * static_cast<std::uint64_t>(choices.log_between(1.0, 3000.0)));
  const Ended run = ended(start_of(work, folder / "disk"));
  return tried(run, broken_by_end(work, folder / "disk", run));
}

/// Without permission to write, or to read, as root or as nobody.
Tried forbidden(const Given& given, Choices& choices, const fs::path& folder) {
  const Work work = given.any_work(choices, given.folder());
  Start start = start_of(work, folder / "own");
  const bool is_root = choices.one_in(2);
  std::optional<Disk> disk;
  if (is_root) {
    disk.emplace(folder / "own", 1 << 20);
    disk->make_read_only();
  } else {
    fs::create_directory(folder / "own");
    constexpr std::array<unsigned, 4> modes{0755, 0555, 0777, 0111};
    fs::permissions(folder / "own", fs::perms(choices.one_of(modes)));
    fs::permissions(folder, fs::perms(0755));
    start.before = [] {
      if (::setgid(nobody) != 0 || ::setuid(nobody) != 0) ::_exit(127);
    };
  }
  const Ended run = ended(start);
  if (!is_root) fs::permissions(folder / "own", fs::perms(0755));
  return tried(run, broken_by_end(work, folder / "own", run));
}

/// All files lie in folders with odd names. All commands succeed, but a scene, which is UTF-8, cannot name other files.
Tried oddly_named(const Given& given, Choices& choices, const fs::path& folder) {
  static const std::vector<std::string> names{
      "a b",    "a\tb",         "a\nb", "-x",   "'q'", "\"d\"", "%s%n", "a;b", "$(id)", "\x1b[31m", "\xff\xfe",
      "\u202e", "\u00e4\u4e2d", "*",    "a\\b", "#",   " ",     "..a",  "a:b", "~",     "a=b,c",    std::string(255, 'n'),
      "{x}",    "</script>"};
  fs::path from = folder / choices.one_of(names);
  if (choices.one_in(3)) from /= choices.one_of(names);
  fs::create_directories(from.parent_path());
  fs::copy(given.folder(), from, fs::copy_options::recursive);
  const Work work = given.any_work(choices, from);
  fs::create_directory(folder / "own");
  const Ended run = ended(start_of(work, folder / "own"));
  std::string broken = broken_by_end(work, folder / "own", run);
  const bool is_done = run.code == 0 || (work.makes == "first.toml" && !detail::is_utf8(from.string()));
  if (broken.empty() && !is_done) broken = "a name is a name: " + run.err.substr(0, 300);
  return tried(run, broken);
}

// ---- campaigns ----

using Fault = Tried (*)(const Given&, Choices&, const fs::path&);

std::string missing() {
  return missing_program("palpa-read").empty() ? missing_program("palpa") : missing_program("palpa-read");
}
std::string missing_root() {
  if (const std::string why = missing(); !why.empty()) return why;
  return ::geteuid() == 0 ? "" : "only root can mount a small disk and become nobody";
}
std::string missing_limits() {
#if defined(__SANITIZE_ADDRESS__)
  return "sanitizers take all addresses that there are, and learn by a pipe what can be read";
#else
  return missing();
#endif
}

Campaign campaign(const std::string& name, Fault fault, std::function<std::string()> missing_here, bool mounts = false) {
  return {.name = "fault " + name,
          .of = "faults",
          .long_tries = 1'700,
          .begin = [=](const fs::path& shared) -> Attempt {
            // Its disks are private, and gone with the process.
            if (mounts && (::unshare(CLONE_NEWNS) != 0 || ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0))
              throw std::runtime_error("no small disk can be mounted where containers forbid it");
            return [fault, given = Given(shared)](Choices& choices, const fs::path& folder) {
              return fault(given, choices, folder);
            };
          },
          .patience_s = 200.0 * slowness,
          .missing = std::move(missing_here)};
}

}  // namespace

void add_faults(std::vector<Campaign>& to) {
  const auto killed = [](const Given& given, Choices& choices, const fs::path& folder) {
    return ended_by(SIGKILL, given, choices, folder);
  };
  const auto asked_to_end = [](const Given& given, Choices& choices, const fs::path& folder) {
    return ended_by(SIGTERM, given, choices, folder);
  };
  to.push_back(campaign("kill", killed, missing));
  to.push_back(campaign("term", asked_to_end, missing));
  to.push_back(campaign("disk", on_full_disk, missing_root, true));
  to.push_back(campaign("descriptors", without_descriptors, missing_limits));
  to.push_back(campaign("memory", without_memory, missing_limits));
  to.push_back(campaign("forbidden", forbidden, missing_root, true));
  to.push_back(campaign("names", oddly_named, missing));
}

}  // namespace palpa::fuzz
