// A compromised reader: tries the escape $ESCAPE within the real readers' sandbox, or without it if $CAGE is "none", and
// returns the result.
#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <linux/io_uring.h>
#include <netinet/in.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/ipc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "palpa/base/load_error.h"
#include "palpa/file/protocol.h"
#include "reader/program.h"
#include "reader/sandbox.h"

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// The test's layout: the reader's file in a folder of its own, and secrets beside that folder.
std::string inside(const char* name) { return variable("INSIDE") + "/" + name; }
std::string outside(const char* name) { return variable("OUTSIDE") + "/" + name; }

int result_of(long answer) { return answer < 0 ? errno : 0; }

int opened(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (file < 0) return errno;
  char byte = 0;
  const bool reads = (flags & (O_ACCMODE | O_DIRECTORY)) == O_RDONLY;
  const int result = reads ? result_of(::read(file, &byte, 1)) : 0;
  ::close(file);
  return result;
}

int connected(int family, const sockaddr* address, socklen_t size) {
  const int file = ::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  return file < 0 ? errno : result_of(::connect(file, address, size));
}

/// A child that ends at once, and is waited for.
int ended(pid_t child) {
  if (child == 0) ::_exit(0);
  if (child < 0) return errno;
  ::waitpid(child, nullptr, 0);
  return 0;
}

int ran(const std::function<void()>& become) {
  ::setenv("RAN", outside("ran").c_str(), 1);
  become();
  return errno;
}

const std::map<std::string, std::function<int()>>& escapes() {
  static const std::map<std::string, std::function<int()>> all{
      // files, to read
      {"read a file outside", [] { return opened(outside("secret"), O_RDONLY); }},
      {"list a folder outside", [] { return opened(outside(""), O_RDONLY | O_DIRECTORY); }},
      {"read by a way back", [] { return opened(inside("../outside/secret"), O_RDONLY); }},
      {"read by a link that leads out", [] { return opened(inside("link"), O_RDONLY); }},
      {"read by openat2",
       [] {
         const std::uint64_t how[3] = {O_RDONLY, 0, 0};
         return result_of(::syscall(SYS_openat2, AT_FDCWD, outside("secret").c_str(), how, sizeof how));
       }},
      {"read the parent's environment", [] { return opened("/proc/" + std::to_string(::getppid()) + "/environ", O_RDONLY); }},
      // files, to write; the disk
      {"make a file", [] { return opened(inside("made"), O_WRONLY | O_CREAT); }},
      {"make a file outside", [] { return opened(outside("made"), O_WRONLY | O_CREAT); }},
      {"make a file without a name", [] { return opened(inside(""), O_WRONLY | O_TMPFILE); }},
      {"write to its own file", [] { return opened(inside("a.nrrd"), O_WRONLY); }},
      {"empty its own file", [] { return opened(inside("victim"), O_RDONLY | O_TRUNC); }},
      {"truncate", [] { return result_of(::truncate(inside("victim").c_str(), 0)); }},
      {"remove", [] { return result_of(::unlink(inside("victim").c_str())); }},
      {"rename", [] { return result_of(::rename(inside("victim").c_str(), inside("moved").c_str())); }},
      {"make a folder", [] { return result_of(::mkdir(inside("folder").c_str(), 0700)); }},
      {"make a link", [] { return result_of(::symlink("/", inside("way").c_str())); }},
      {"change a mode", [] { return result_of(::chmod(inside("victim").c_str(), 0777)); }},
      {"change the mode of an open file",
       [] {
         const int file = ::open(inside("victim").c_str(), O_RDONLY | O_CLOEXEC);
         return file < 0 ? errno : result_of(::fchmod(file, 0777));
       }},
      {"fill the caller's output",
       [] {
         struct stat before{}, after{};
         ::stat(outside("output").c_str(), &before);
         if (::write(STDOUT_FILENO, "filled", 6) < 0) return errno;
         ::stat(outside("output").c_str(), &after);
         return after.st_size > before.st_size ? 0 : EACCES;
       }},
      // the network
      {"connect by TCP",
       [] {
         sockaddr_in to{};
         to.sin_family = AF_INET, to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(variable("PORT"))));
         to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
         return connected(AF_INET, reinterpret_cast<const sockaddr*>(&to), sizeof to);
       }},
      {"send by UDP",
       [] {
         sockaddr_in to{};
         to.sin_family = AF_INET, to.sin_port = htons(9), to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
         const int file = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
         if (file < 0) return errno;
         return result_of(::sendto(file, "x", 1, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to));
       }},
      {"connect to a program of this machine",
       [] {
         sockaddr_un to{};
         to.sun_family = AF_UNIX;
         std::strncpy(to.sun_path, outside("socket").c_str(), sizeof to.sun_path - 1);
         return connected(AF_UNIX, reinterpret_cast<const sockaddr*>(&to), sizeof to);
       }},
      {"type into the terminal",  // only an attempt: without a terminal it fails by itself
       [] {
         int bytes = 0;
         return result_of(::ioctl(palpa::protocol::socket_descriptor, FIONREAD, &bytes));
       }},
      // programs
      {"run a program",
       [] {
         const int child = ::vfork();
         if (child == 0) {
           ::execl("/bin/true", "true", nullptr);
           ::_exit(1);
         }
         int status = 0;
         if (child < 0) return errno;
         return ::waitpid(child, &status, 0) == child && status == 0 ? 0 : EACCES;
       }},
      {"become a program", [] { return ran([] { ::execl("/bin/sh", "sh", "-c", ": >\"$RAN\"", nullptr); }); }},
      {"become a program by its descriptor",
       [] {
         return ran([] {
           const int file = ::open("/bin/sh", O_RDONLY);
           char shell[] = "sh", option[] = "-c", line[] = ": >\"$RAN\"";
           char* arguments[] = {shell, option, line, nullptr};
           ::syscall(SYS_execveat, file, "", arguments, environ, AT_EMPTY_PATH);
         });
       }},
      {"fork", [] { return ended(::fork()); }},
      {"fork by clone", [] { return ended(static_cast<pid_t>(::syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0))); }},
      {"fork by clone3",
       [] {
         std::uint64_t arguments[8] = {0, 0, 0, 0, SIGCHLD};
         return ended(static_cast<pid_t>(::syscall(SYS_clone3, arguments, sizeof arguments)));
       }},
      {"leave the group that its caller ends", [] { return result_of(::setpgid(0, ::getpgid(::getppid()))); }},
      {"outlive the caller", [] { return result_of(::prctl(PR_SET_PDEATHSIG, 0)); }},
      // the caller's memory
      {"trace the caller",
       [] {
         const long answer = ::ptrace(PTRACE_SEIZE, ::getppid(), nullptr, nullptr);
         const int result = result_of(answer);
         if (answer == 0) ::ptrace(PTRACE_DETACH, ::getppid(), nullptr, nullptr);
         return result;
       }},
      {"read the caller's memory",
       [] {
         char bytes[4] = {};
         const iovec here{bytes, sizeof bytes};
         const iovec there{reinterpret_cast<void*>(std::stoull(variable("SECRET_AT"))), sizeof bytes};
         return result_of(::process_vm_readv(::getppid(), &here, 1, &there, 1, 0));
       }},
      {"write the caller's memory",
       [] {
         char bytes[4] = {'g', 'o', 'n', 'e'};
         const iovec here{bytes, sizeof bytes};
         const iovec there{reinterpret_cast<void*>(std::stoull(variable("SECRET_AT"))), sizeof bytes};
         return result_of(::process_vm_writev(::getppid(), &here, 1, &there, 1, 0));
       }},
      {"read the caller's memory as a file",
       [] {
         const int file = ::open(("/proc/" + std::to_string(::getppid()) + "/mem").c_str(), O_RDONLY | O_CLOEXEC);
         char bytes[4] = {};
         return file < 0
                    ? errno
                    : result_of(::pread(file, bytes, sizeof bytes, static_cast<off_t>(std::stoull(variable("SECRET_AT")))));
       }},
      // signals
      {"send the caller a signal", [] { return result_of(::kill(::getppid(), SIGURG)); }},
      {"send the caller's thread a signal", [] { return result_of(::syscall(SYS_tgkill, ::getppid(), ::getppid(), SIGURG)); }},
      {"send a signal by a descriptor",
       [] {
         const long process = ::syscall(SYS_pidfd_open, ::getppid(), 0);
         return process < 0 ? errno : result_of(::syscall(SYS_pidfd_send_signal, process, SIGURG, nullptr, 0));
       }},
      // memory and limits
      {"take memory without end",
       [] {
         void* memory =
             ::mmap(nullptr, std::size_t{1} << 46, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
         return memory == MAP_FAILED ? errno : 0;
       }},
      {"make a file of memory", [] { return result_of(::memfd_create("more", MFD_CLOEXEC)); }},
      {"make memory that stays",
       [] {
         const int memory = ::shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600);
         if (memory < 0) return errno;
         ::shmctl(memory, IPC_RMID, nullptr);
         return 0;
       }},
      {"change its limits",
       [] {
         rlimit limit{};
         ::getrlimit(RLIMIT_NOFILE, &limit);
         return result_of(::setrlimit(RLIMIT_NOFILE, &limit));
       }},
      {"change the caller's limits",
       [] {
         rlimit limit{};
         ::prlimit(::getppid(), RLIMIT_NOFILE, nullptr, &limit);
         return result_of(::prlimit(::getppid(), RLIMIT_NOFILE, &limit, nullptr));
       }},
      // ways round the filter
      {"have the kernel call for it",
       [] {
         io_uring_params parameters{};
         const long ring = ::syscall(SYS_io_uring_setup, 1, &parameters);
         return result_of(ring);
       }},
      {"take a namespace of its own", [] { return result_of(::unshare(CLONE_FILES | CLONE_FS)); }},
  };
  return all;
}

void escape(int socket) {
  using namespace palpa;
  const protocol::Request request = reader::receive_request(socket, true);
  std::string lacking;
  if (variable("CAGE") == "network") {
    lacking = reader::enter_cage_with_network();
  } else if (variable("CAGE") != "none") {
    lacking = reader::enter_cage(request);
    reader::close_cage();
  }
  const std::string name = variable("ESCAPE");
  if (name == "which parts are lacking?") throw LoadError("lacks: " + lacking);
  const int result = escapes().at(name)();
  // Messages in a reader's format: others are quoted.
  throw LoadError(result == 0 ? "escaped; nothing held it" : std::string("refused: ") + std::strerror(result) + "; it is held");
}

/// Becomes a real reader on a kernel without a part, emulated by another filter.
int read_without(const std::string& part, char** arguments) {
  const std::unique_ptr<void, decltype(&::seccomp_release)> filter(::seccomp_init(SCMP_ACT_ALLOW), ::seccomp_release);
  const std::uint32_t missing = SCMP_ACT_ERRNO(ENOSYS);
  if (part == "Landlock") {
    ::seccomp_rule_add(filter.get(), missing, SCMP_SYS(landlock_create_ruleset), 0);
  } else {
    ::seccomp_rule_add(filter.get(), missing, SCMP_SYS(seccomp), 0);
    ::seccomp_rule_add(filter.get(), missing, SCMP_SYS(prctl), 1, SCMP_A0_32(SCMP_CMP_EQ, PR_SET_SECCOMP));
  }
  if (::seccomp_load(filter.get()) != 0) return 3;
  ::execv(variable("REAL_READER").c_str(), arguments);
  return 4;
}

}  // namespace

int main(int count, char** arguments) {
  if (const std::string part = variable("KERNEL_WITHOUT"); !part.empty()) return read_without(part, arguments);
  if (count == 2 && std::string_view(arguments[1]) == "--list") {
    for (const auto& [name, tried] : escapes()) std::puts(name.c_str());
    return 0;
  }
  return palpa::reader::run_program(escape);
}
