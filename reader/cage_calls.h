// System calls of the sandbox, compiled into filters at build time. Calls in no table fail with ENOSYS: libraries do without.
#pragma once

#include <fcntl.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

namespace palpa::reader {

enum class Answer : std::uint8_t {
  allowed,
  refused,  ///< EACCES, which libraries report like a missing permission
  ended,    ///< kills the process: no undamaged reader makes this call
  missing,  ///< ENOSYS: libraries take an older call, whose arguments a filter can read
};
using enum Answer;

struct Calls {
  Answer answer;
  const char* names;  ///< separated by blanks; calls missing on this machine are skipped
};

inline constexpr Calls calls[] = {
    // memory, time, threads
    {allowed, "brk madvise membarrier mmap mmap2 mprotect mremap msync munmap"},
    {allowed, "clock_getres clock_gettime clock_nanosleep gettimeofday nanosleep restart_syscall time times"},
    {allowed, "arch_prctl exit exit_group futex get_robust_list getcpu rseq sched_getaffinity sched_getparam"},
    {allowed, "sched_getscheduler sched_yield set_robust_list set_thread_area set_tid_address"},
    // own signals and identity
    {allowed, "rt_sigaction rt_sigpending rt_sigprocmask rt_sigreturn sigaltstack"},
    {allowed, "getcwd getegid geteuid getgid getpgid getpgrp getpid getppid getrandom getresgid getresuid getrlimit"},
    {allowed, "getrusage gettid getuid sysinfo ugetrlimit uname"},
    // reading of files and folders; use of open files, including voxel memory and the caller's socket
    {allowed, "access faccessat faccessat2 fstat fstatfs getdents getdents64 lstat newfstatat readlink readlinkat stat"},
    {allowed, "statfs statx"},
    {allowed, "close close_range dup dup2 dup3 fadvise64 flock ftruncate lseek poll ppoll pread64 preadv pselect6 pwrite64"},
    {allowed, "pwritev read readahead readv recvfrom recvmsg select sendmsg write writev"},
    // changes to files; sockets, which libraries may request, as for users' names; terminals
    {refused, "chmod chown creat fchmod fchmodat fchown fchownat fremovexattr fsetxattr futimesat lchown link linkat"},
    {refused, "lremovexattr lsetxattr mkdir mkdirat mknod mknodat removexattr rename renameat renameat2 rmdir setxattr"},
    {refused, "symlink symlinkat truncate unlink unlinkat utime utimensat utimes"},
    {refused, "ioctl socket socketpair"},
    // other programs and processes
    {ended, "execveat fork vfork"},
    {ended, "kcmp kill pidfd_getfd pidfd_open pidfd_send_signal process_vm_readv process_vm_writev ptrace"},
    {ended, "rt_sigqueueinfo rt_tgsigqueueinfo setpgid setsid tkill"},
    // network, kernel, further rights
    {ended, "accept accept4 bind connect listen"},
    {ended, "add_key bpf finit_module init_module io_uring_setup kexec_load keyctl perf_event_open reboot request_key"},
    {ended, "swapon userfaultfd"},
    {ended, "capset chroot mount open_by_handle_at pivot_root setgid setgroups setns setregid setresgid setresuid"},
    {ended, "setreuid setuid umount2 unshare"},
};

/// Calls by which palpa-read becomes one of its programs, which then disables them.
inline constexpr const char* calls_to_become = "execve seccomp";

/// `argument & mask == value`.
struct Condition {
  unsigned argument = 0;
  std::uint64_t mask = 0, value = 0;
};

struct Rule {
  Answer answer;
  std::string call;
  std::vector<Condition> when{};  ///< all must hold
};

/// Placeholder of the process id, known when the filter is loaded; larger than any process id.
inline constexpr std::uint32_t own_process = 0x7fffff0f;

/// Rules for calls that depend on their arguments.
inline std::vector<Rule> rules_of_arguments() {
  constexpr std::uint64_t all = UINT64_MAX, low = UINT32_MAX;  // 64-bit argument; int argument, whose upper half is undefined
  constexpr std::uint64_t namespaces =
      CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;
  std::vector<Rule> rules{
      // opened for reading only
      {allowed, "open", {{1, O_ACCMODE | O_CREAT | O_TRUNC, O_RDONLY}}},
      {allowed, "openat", {{2, O_ACCMODE | O_CREAT | O_TRUNC, O_RDONLY}}},
      // threads, no processes
      {allowed, "clone", {{0, CLONE_THREAD | namespaces, CLONE_THREAD}}},
      {ended, "clone", {{0, CLONE_THREAD, 0}}},
      // signals to itself, as from abort
      {allowed, "tgkill", {{0, low, own_process}}},
      // own limits: read all, set memory (serve.cpp)
      {allowed, "prlimit64", {{0, low, 0}, {2, all, 0}}},
      {allowed, "prlimit64", {{0, low, 0}, {1, low, RLIMIT_AS}}},
      // to the socket's other end, to no address
      {allowed, "sendto", {{4, all, 0}}},
      // end with the caller
      {allowed, "prctl", {{0, low, PR_SET_PDEATHSIG}, {1, all, SIGKILL}}},
  };
  for (const std::uint64_t bit : {O_WRONLY, O_RDWR, O_CREAT, O_TRUNC}) {
    rules.push_back({refused, "open", {{1, bit, bit}}});
    rules.push_back({refused, "openat", {{2, bit, bit}}});
  }
  for (const std::uint64_t what : {PR_SET_NO_NEW_PRIVS, PR_GET_NO_NEW_PRIVS, PR_SET_NAME, PR_GET_NAME, PR_GET_DUMPABLE})
    rules.push_back({allowed, "prctl", {{0, low, what}}});
  // descriptors, not the receiver of their signals
  for (const std::uint64_t what :
       {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_GETLK, F_SETLK, F_OFD_GETLK, F_OFD_SETLK})
    rules.push_back({allowed, "fcntl", {{1, low, what}}});
  return rules;
}

/// Of palpa-fetch, which is allowed all others: it has no file that it may write, and connects, but is never connected to.
inline constexpr Calls calls_with_network[] = {
    {ended, "execve execveat fork vfork accept accept4 listen"},
    {ended, "kcmp kill pidfd_getfd pidfd_open pidfd_send_signal process_vm_readv process_vm_writev ptrace"},
    {ended, "rt_sigqueueinfo rt_tgsigqueueinfo setpgid setsid tkill"},
    {ended, "add_key bpf finit_module init_module io_uring_setup kexec_load keyctl perf_event_open reboot request_key"},
    {ended, "swapon userfaultfd"},
    {ended, "capset chroot mount open_by_handle_at pivot_root setgid setgroups setns setregid setresgid setresuid"},
    {ended, "setreuid setuid umount2 unshare"},
    {refused, "chmod chown fchmod fchmodat fchown fchownat fremovexattr fsetxattr futimesat lchown link linkat"},
    {refused, "lremovexattr lsetxattr mkdir mkdirat mknod mknodat removexattr rename renameat renameat2 rmdir setxattr"},
    {refused, "symlink symlinkat truncate unlink unlinkat utime utimensat utimes"},
    {refused, "msgget semget setrlimit shmat shmget"},
    {missing, "clone3 openat2 prlimit64"},
};

/// Its calls that depend on their arguments.
inline std::vector<Rule> rules_with_network() {
  constexpr std::uint64_t low = UINT32_MAX, families = 64;  // of sockets: more than there are
  std::vector<Rule> rules{{ended, "clone", {{0, CLONE_THREAD, 0}}},
                          {refused, "ioctl", {{1, low, TIOCSTI}}},
                          {refused, "prctl", {{0, low, PR_SET_PDEATHSIG}}}};
  for (std::uint64_t family = 0; family < families; ++family) {
    if (family != AF_INET && family != AF_INET6 && family != AF_NETLINK)
      rules.push_back({refused, "socket", {{0, low, family}}});
  }
  return rules;
}

}  // namespace palpa::reader
