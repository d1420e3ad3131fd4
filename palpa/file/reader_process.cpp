#include "palpa/file/reader_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <fstream>
#include <functional>
#include <future>
#include <mutex>
#include <sstream>
#include <system_error>
#include <thread>

#include "palpa/base/load_error.h"
#include "palpa/base/own_files.h"
#include "palpa/base/printed.h"

namespace palpa::detail {
namespace {

/// Period of checks of the reader's time and memory. Longer: a reader can take more before it is stopped; shorter: more
/// wake-ups.
constexpr auto look_every = std::chrono::milliseconds(100);
/// Least speed of a reader that is not stuck: a slow disk or machine, a sanitizer build. Higher: slow readers are stopped;
/// lower: a stuck one lasts longer.
constexpr double work_bytes_per_s = 20e6;
/// Limit of a reader's threads: its libraries start one per processor. More: a thread bomb takes more of the system's; fewer:
/// valid files are refused on large machines.
constexpr std::uint64_t most_threads = 2048;

bool can_be_run(const std::filesystem::path& program) {
  std::error_code none;
  return std::filesystem::is_regular_file(program, none) && ::access(program.c_str(), X_OK) == 0;
}

/// Longest wait for the end of a killed reader. Longer: a frozen mount holds the caller; shorter: zombies on a busy machine.
constexpr auto longest_end = std::chrono::seconds(3);

std::string seconds(double s) { return detail::text("%g s", s); }

}  // namespace

std::filesystem::path find_reader(const std::filesystem::path& option) {
  if (!option.empty()) {
    if (can_be_run(option)) return option;
    throw LoadError("cannot be opened: '" + option.string() + "' is no program; give the path of palpa-read");
  }
  if (const char* variable = std::getenv("PALPA_READER"); variable != nullptr && *variable != '\0') {
    if (can_be_run(variable)) return variable;
    throw LoadError("cannot be opened: PALPA_READER is '" + std::string(variable) +
                    "', which is no program; set it to the path of palpa-read");
  }
  for (const std::filesystem::path& folder : own_files_folders()) {
    if (can_be_run(folder / "palpa-read")) return folder / "palpa-read";
  }
  throw LoadError("cannot be opened: the program palpa-read is not beside this one; build it, or set PALPA_READER to its path");
}

std::string lacking_of_cage() {
  std::string reader;
  try {
    reader = find_reader({}).string();
  } catch (const LoadError&) {
    return {};
  }
  int pipe[2] = {-1, -1};
  if (::pipe2(pipe, O_CLOEXEC) != 0) return {};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
  char option[] = "--cage";
  char* arguments[] = {reader.data(), option, nullptr};
  pid_t pid = -1;
  const int problem = ::posix_spawn(&pid, reader.c_str(), &actions, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[1]);
  std::string words(1024, '\0');
  pollfd ready{pipe[0], POLLIN, 0};
  const ssize_t size = problem == 0 && ::poll(&ready, 1, 5000) > 0 ? ::read(pipe[0], words.data(), words.size()) : 0;
  ::close(pipe[0]);
  if (problem == 0) ::kill(pid, SIGKILL), ::waitpid(pid, nullptr, 0);
  words.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  return words.substr(0, words.find('\n'));
}

namespace {

/// Thread that starts readers: each is ended with the thread that started it (PR_SET_PDEATHSIG), and one that serves a store
/// outlives the thread that opened it. Lives as long as this process.
class ThreadOfReaders {
 public:
  /// Runs `start` on the thread; returns its result, or EAGAIN where there can be no thread.
  static int run(const std::function<int()>& start) {
    std::packaged_task<int()> task(start);
    std::future<int> result = task.get_future();
    try {
      ThreadOfReaders& thread = of_this_process();
      const std::scoped_lock lock(thread.mutex_);
      thread.waiting_.push_back(std::move(task));
      thread.changed_.notify_one();
    } catch (const std::system_error&) {
      return EAGAIN;
    }
    return result.get();
  }

 private:
  ThreadOfReaders() {
    std::thread([this] { work(); }).detach();
  }

  /// A forked process has no thread of its parent's. Never destroyed.
  static ThreadOfReaders& of_this_process() {
    static std::mutex mutex;
    static pid_t process = -1;
    static ThreadOfReaders* thread = nullptr;
    const std::scoped_lock lock(mutex);
    if (process != ::getpid()) thread = new ThreadOfReaders, process = ::getpid();
    return *thread;
  }

  void work() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, nullptr);  // signals are for other threads
    while (true) {
      std::packaged_task<int()> task;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !waiting_.empty(); });
        task = std::move(waiting_.front());
        waiting_.pop_front();
      }
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::packaged_task<int()>> waiting_;
};

}  // namespace

ReaderProcess::ReaderProcess(const std::filesystem::path& program, double idle_limit_s, std::stop_token stop)
    : idle_limit_s_(idle_limit_s), stop_(std::move(stop)) {
  int pair[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) {
    throw LoadError(std::string("cannot be opened: no socket for palpa-read (") + std::strerror(errno) + "); close some files");
  }
  // In a process group of its own, so that ending it ends its children, and Ctrl-C reaches the caller alone. Its standard input
  // is empty; it inherits the socket and the standard three descriptors.
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, pair[1], protocol::socket_descriptor);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, protocol::socket_descriptor + 1);
  sigset_t no_signals, all_signals;
  ::sigemptyset(&no_signals);
  ::sigfillset(&all_signals);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setsigmask(&attributes, &no_signals);
  ::posix_spawnattr_setsigdefault(&attributes, &all_signals);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string name = program.string();
  char* arguments[] = {name.data(), nullptr};
  const int problem =
      ThreadOfReaders::run([&] { return ::posix_spawn(&pid_, name.c_str(), &actions, &attributes, arguments, environ); });
  // Priority of the calling thread, as if it had started the reader itself.
  if (problem == 0) ::setpriority(PRIO_PROCESS, static_cast<id_t>(pid_), ::getpriority(PRIO_PROCESS, 0));
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(pair[1]);
  if (problem != 0) {
    ::close(pair[0]);
    pid_ = -1;
    throw LoadError("cannot be opened: '" + name + "' does not start (" + std::strerror(problem) + "); build palpa-read again");
  }
  socket_ = pair[0];
}

ReaderProcess::~ReaderProcess() {
  end();
  ::close(socket_);
}

int ReaderProcess::end() noexcept {
  if (pid_ < 0) return -1;
  ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);
  int status = -1;
  pid_t reaped = 0;
  // The system holds a killed process that is blocked by a frozen mount; the caller is not to be held with it.
  const Clock::time_point latest = Clock::now() + longest_end;
  for (unsigned wait_us = 50; (reaped = ::waitpid(pid_, &status, WNOHANG)) <= 0; wait_us = std::min(2 * wait_us, 10'000U)) {
    if ((reaped < 0 && errno != EINTR) || Clock::now() > latest) break;
    ::usleep(wait_us);
  }
  pid_ = -1;
  return reaped <= 0 ? -1 : status;
}

bool ReaderProcess::send(const protocol::Message& message, const protocol::MemoryFiles& with) {
  pollfd ready{socket_, POLLOUT, 0};
  const auto latest = Clock::now() + std::chrono::duration<double>(idle_limit_s_);
  while (::poll(&ready, 1, static_cast<int>(look_every.count())) <= 0) {
    if (stop_.stop_requested()) throw LoadError("was not read: it was cancelled; open it again");
    if (Clock::now() > latest) {
      end();
      throw LoadError("cannot be read: palpa-read took no message for " + seconds(idle_limit_s_) +
                      " and was ended; check that the disk answers");
    }
  }
  return protocol::send(socket_, message, with.first, with.second);
}

protocol::Message ReaderProcess::receive(std::uint64_t work_bytes, std::uint64_t memory_bytes) {
  begin_work();
  while (true) {
    pollfd ready{socket_, POLLIN, 0};
    const int events = ::poll(&ready, 1, static_cast<int>(look_every.count()));
    if (events > 0) break;
    if (events < 0 && errno != EINTR) report_end();
    if (stop_.stop_requested()) throw LoadError("was not read: it was cancelled; open it again");
    watch(work_bytes, memory_bytes);
  }
  return take();
}

std::optional<protocol::Message> ReaderProcess::receive_within(double timeout_s) {
  pollfd ready{socket_, POLLIN, 0};
  const timespec longest{static_cast<std::time_t>(timeout_s), static_cast<long>(1e9 * (timeout_s - std::floor(timeout_s)))};
  const int events = ::ppoll(&ready, 1, &longest, nullptr);
  if (events < 0 && errno != EINTR) report_end();
  if (events <= 0) return std::nullopt;
  return take();
}

void ReaderProcess::begin_work() {
  last_progress_ = begin_of_work_ = Clock::now();
  is_new_work_ = true;
}

double ReaderProcess::working_s() const noexcept {
  return std::chrono::duration<double>(Clock::now() - begin_of_work_).count();
}

protocol::Message ReaderProcess::take() {
  bool garbled = false;
  auto received = protocol::receive(socket_, garbled);
  for (const int descriptor : {received ? received->descriptor : -1, received ? received->second_descriptor : -1}) {
    if (descriptor >= 0) ::close(descriptor);
  }
  if (garbled) throw LoadError("cannot be read: palpa-read does not speak as this program does; update both together");
  if (!received) report_end();
  return std::move(received->message);
}

void ReaderProcess::watch(std::uint64_t work_bytes, std::uint64_t memory_bytes) {
  const std::string process = "/proc/" + std::to_string(pid_);

  // utime and stime are fields 14 and 15, the number of threads is field 20; the second field, the name, may hold anything up
  // to its ')'.
  std::uint64_t cpu_ticks = last_cpu_ticks_, threads = 0;
  std::string line;
  if (std::ifstream stat(process + "/stat"); std::getline(stat, line) && line.rfind(')') != std::string::npos) {
    std::istringstream fields(line.substr(line.rfind(')') + 1));
    std::string skipped;
    std::uint64_t user = 0, system = 0;
    for (int field = 3; field < 14; ++field) fields >> skipped;
    if (fields >> user >> system) cpu_ticks = user + system;
    for (int field = 16; field < 20; ++field) fields >> skipped;
    fields >> threads;
  }
  std::uint64_t bytes_read = last_bytes_read_;
  if (std::ifstream io(process + "/io"); io >> line >> bytes_read && line != "rchar:") bytes_read = last_bytes_read_;
  std::uint64_t pages = 0, resident_pages = 0, shared_pages = 0;
  std::ifstream(process + "/statm") >> pages >> resident_pages >> shared_pages;

  const bool has_read = bytes_read != last_bytes_read_;
  const bool has_worked = cpu_ticks != last_cpu_ticks_;
  last_bytes_read_ = bytes_read;
  last_cpu_ticks_ = cpu_ticks;
  if (has_read || is_new_work_) cpu_ticks_at_read_ = cpu_ticks;
  is_new_work_ = false;
  if (has_read || has_worked) last_progress_ = Clock::now();

  const double idle_s = std::chrono::duration<double>(Clock::now() - last_progress_).count();
  const double busy_s = static_cast<double>(cpu_ticks - cpu_ticks_at_read_) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  if (idle_s > idle_limit_s_) {
    throw LoadError("cannot be read: palpa-read made no progress for " + seconds(idle_limit_s_) +
                    " and was ended; check that the disk answers");
  }
  if (busy_s > idle_limit_s_ + static_cast<double>(work_bytes) / work_bytes_per_s) {
    throw LoadError("cannot be read: palpa-read computed for " + seconds(idle_limit_s_) +
                    " without reading on and was ended; the file is probably damaged");
  }
  if (threads > most_threads) {
    throw LoadError("cannot be read: palpa-read started more than " + std::to_string(most_threads) +
                    " threads and was ended; the file is probably damaged");
  }
  if (resident_pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) > memory_bytes) {
    throw LoadError("cannot be read: palpa-read took more than " + protocol::readable_bytes(static_cast<double>(memory_bytes)) +
                    " and was ended; the file is probably damaged");
  }
}

void ReaderProcess::report_end() {
  // It has ended or is about to: a short grace for its status.
  int status = -1;
  for (int wait = 0; wait < 100; ++wait) {
    const pid_t reaped = ::waitpid(pid_, &status, WNOHANG);
    if (reaped == pid_) {
      ::kill(-pid_, SIGKILL);
      pid_ = -1;
      break;
    }
    if (reaped < 0 && errno != EINTR) break;
    ::usleep(10'000);
  }
  if (pid_ >= 0) status = end();
  if (status != -1 && WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS) {
    throw LoadError(
        "cannot be read: palpa-read tried what its cage forbids and was ended; do not trust the file: it may be made "
        "to do harm");
  }
  std::string how = "ended";
  if (status != -1 && WIFSIGNALED(status))
    how = std::string("was ended by signal ") + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")";
  if (status != -1 && WIFEXITED(status)) how = "ended with code " + std::to_string(WEXITSTATUS(status));
  throw LoadError("cannot be read: palpa-read " + how + " before it was done; the file is probably damaged");
}

}  // namespace palpa::detail
