#include "sandbox.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/auxv.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <vector>

#include "cage_calls.h"
#include "cage_filters.inc"
#include "file_names.h"
#include "palpa/base/load_error.h"
#include "palpa/base/web_address.h"

// Missing in linux/landlock.h of kernel 6.1 (Debian 12).
#ifndef LANDLOCK_ACCESS_FS_TRUNCATE
#define LANDLOCK_ACCESS_FS_TRUNCATE (1ULL << 14)  // version 3
#endif
#ifndef LANDLOCK_ACCESS_NET_BIND_TCP
#define LANDLOCK_ACCESS_NET_BIND_TCP (1ULL << 0)  // version 4
#define LANDLOCK_ACCESS_NET_CONNECT_TCP (1ULL << 1)
#endif
#ifndef LANDLOCK_ACCESS_FS_IOCTL_DEV
#define LANDLOCK_ACCESS_FS_IOCTL_DEV (1ULL << 15)  // version 5
#endif
#ifndef LANDLOCK_SCOPE_SIGNAL
#define LANDLOCK_SCOPE_ABSTRACT_UNIX_SOCKET (1ULL << 0)  // version 6
#define LANDLOCK_SCOPE_SIGNAL (1ULL << 1)
#endif

namespace palpa::reader {
namespace {

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace fs = std::filesystem;

// ---------------------------------------------------------------------------------------------------------------------------
// Permissions: first files, by Landlock, for reading only: the folders of the caller's files (add_folders_of), and these of the
// system, none of them the user's.

constexpr const char* libraries = "/usr /lib /lib64 /opt /etc/ld.so.cache /etc/localtime";
constexpr const char* process_and_machine = "/proc/self /proc/cpuinfo /proc/meminfo /proc/stat /sys/devices/system";

/// Of palpa-fetch, for names of servers and for certificates.
constexpr const char* names_and_certificates = "/etc /run/systemd/resolve /run/resolvconf /run/NetworkManager";

/// Variables with further folders, separated by ':': the user's, for files far from their header, and the dynamic linker's.
constexpr const char* folder_variables[] = {"PALPA_READER_FOLDERS", "LD_LIBRARY_PATH"};

// Then system calls, by seccomp: cage_calls.h.

// Limits by the kernel, beside that of memory, which depends on the file (serve.cpp). RLIMIT_NPROC counts all processes of the
// user, so a limit against a bomb of threads would refuse sound files. Processes cannot be made; the caller counts threads and
// ends a reader with too many.

/// Computing time beside that for the permitted voxels. More: a hanging reader lasts longer; less: slow files are refused.
constexpr std::uint64_t most_cpu_s = 3600, cpu_bytes_per_s = 10'000'000;
/// Address space beside those voxels, in memories of the machine: serve's own limit is lower, but can be raised up to here.
constexpr std::uint64_t most_memories = 2;

// ---------------------------------------------------------------------------------------------------------------------------

/// Nonempty parts of a list.
std::vector<std::string> split(const char* list, char mark) {
  std::istringstream text(list);
  std::vector<std::string> parts;
  for (std::string part; std::getline(text, part, mark);) {
    if (!part.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

struct Folders {
  std::vector<std::string> to_read, to_run;
};

/// Adds the folder of a file, as named and, for a link, resolved; a folder or an OpenFOAM case itself.
void add_folders_of(const std::string& path, std::vector<std::string>& folders) {
  if (path.empty() || is_web_address(path)) return;
  std::error_code ignored;
  if (const fs::path of_case = openfoam_case(path); !of_case.empty()) folders.push_back(of_case.string());
  if (fs::is_directory(path, ignored)) return folders.push_back(path);
  for (const fs::path& file : {fs::absolute(path, ignored), fs::canonical(path, ignored)})
    if (!file.empty()) folders.push_back(file.parent_path().string());
}

Folders folders_of(const protocol::Request& request) {
  Folders folders;
  for (const char* places : {libraries, process_and_machine}) {
    for (std::string& place : split(places, ' ')) folders.to_read.push_back(std::move(place));
  }
  add_folders_of(request.path, folders.to_read);
  for (const std::string& partner : request.partners) add_folders_of(partner, folders.to_read);
  for (const char* variable : folder_variables) {
    const char* list = std::getenv(variable);
    for (std::string& folder : split(list != nullptr ? list : "", ':')) folders.to_read.push_back(std::move(folder));
  }
  std::error_code ignored;
  folders.to_run.push_back(fs::read_symlink("/proc/self/exe", ignored).parent_path().string());
  // The dynamic linker, which the kernel runs first.
  Dl_info linker{};
  if (::dladdr(reinterpret_cast<const void*>(::getauxval(AT_BASE)), &linker) != 0 && linker.dli_fname != nullptr)
    folders.to_run.emplace_back(linker.dli_fname);
  return folders;
}

/// The kernel's struct with the members of later versions: earlier kernels accept zeros for these.
struct Ruleset {
  std::uint64_t files = 0, net = 0, scopes = 0;
};

struct Closer {
  int descriptor;
  ~Closer() {
    if (descriptor >= 0) ::close(descriptor);
  }
};

/// Allows reading in these folders, no other files, and connections by TCP if wanted. Returns 0 or errno.
int allow_files(const Folders& folders, bool connects = false) {
  const auto version = static_cast<int>(::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
  if (version < 0) return errno;
  Ruleset rules{(LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1};  // all of version 1
  if (version >= 2) rules.files |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) rules.files |= LANDLOCK_ACCESS_FS_TRUNCATE;
  if (version >= 4) rules.net = LANDLOCK_ACCESS_NET_BIND_TCP | (connects ? 0 : LANDLOCK_ACCESS_NET_CONNECT_TCP);
  if (version >= 5) rules.files |= LANDLOCK_ACCESS_FS_IOCTL_DEV;
  if (version >= 6) rules.scopes = LANDLOCK_SCOPE_ABSTRACT_UNIX_SOCKET | LANDLOCK_SCOPE_SIGNAL;
  const Closer ruleset{static_cast<int>(::syscall(SYS_landlock_create_ruleset, &rules, sizeof rules, 0))};
  if (ruleset.descriptor < 0) return errno;
  const auto allow = [&](const std::string& path, std::uint64_t access) {
    const Closer place{::open(path.c_str(), O_PATH | O_CLOEXEC)};
    struct stat status{};
    if (place.descriptor < 0 || ::fstat(place.descriptor, &status) != 0) return;  // missing paths need no rule
    if (S_ISDIR(status.st_mode)) access |= LANDLOCK_ACCESS_FS_READ_DIR;
    const landlock_path_beneath_attr beneath{access, place.descriptor};
    ::syscall(SYS_landlock_add_rule, ruleset.descriptor, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0);
  };
  for (const std::string& path : folders.to_read) allow(path, LANDLOCK_ACCESS_FS_READ_FILE);
  for (const std::string& path : folders.to_run) allow(path, LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_EXECUTE);
  return ::syscall(SYS_landlock_restrict_self, ruleset.descriptor, 0) == 0 ? 0 : errno;
}

/// Loads a filter of system calls, for all threads. Returns 0 or errno.
template <std::size_t N>
int load(const sock_filter (&made)[N]) {
  sock_filter steps[N];
  std::copy_n(made, N, steps);
  for (sock_filter& step : steps) {
    if (step.k == own_process) step.k = static_cast<std::uint32_t>(::getpid());
  }
  const sock_fprog program{N, steps};
  // A single process without secrets from itself: full speed.
  constexpr unsigned flags = SECCOMP_FILTER_FLAG_TSYNC | SECCOMP_FILTER_FLAG_SPEC_ALLOW;
  const long result = ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, flags, &program);
  return result < 0 ? errno : result > 0 ? ESRCH : 0;  // above 0: a thread with another filter
}

void limit(int resource, std::uint64_t most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  now.rlim_max = std::min<rlim_t>(now.rlim_max, most);
  now.rlim_cur = std::min(now.rlim_cur, now.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

#endif

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// Sanitizer runtimes restart themselves, map terabytes, read the program's files at exit and write to stderr: all forbidden
// here.
std::string enter_cage(const protocol::Request&) { return "all of it: this is a build with a sanitizer"; }
void close_cage() {}
std::string enter_cage_with_network() { return "all of it: this is a build with a sanitizer"; }
#else
std::string enter_cage(const protocol::Request& request) {
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  // Chunks and rows are served as long as the caller lives, with a limit for each (zarr_serve.cpp, store_reader.cpp).
  if (!request.store && !request.rows) limit(RLIMIT_CPU, most_cpu_s + request.max_bytes / cpu_bytes_per_s);
  limit(RLIMIT_FSIZE, request.max_bytes);  // memory for voxels is files, too
  const std::uint64_t memory_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGESIZE);
  limit(RLIMIT_AS, std::min(request.max_bytes, UINT64_MAX / 2) + most_memories * memory_bytes);
  // The caller's standard output may be a file or a terminal. Its standard error stays until the next program has started.
  if (const Closer nothing{::open("/dev/null", O_WRONLY | O_CLOEXEC)}; nothing.descriptor >= 0)
    ::dup2(nothing.descriptor, STDOUT_FILENO);
  std::string lacking;
  const auto note = [&](const char* part, int problem) {
    if (problem != 0) lacking += (lacking.empty() ? "" : ", ") + std::string(part) + " (" + std::strerror(problem) + ")";
  };
  note("Landlock", allow_files(folders_of(request)));
  note("seccomp", load(allowed_calls));
  return lacking;
}

std::string enter_cage_with_network() {
  // [bytes] More of either: a hostile server can take more memory; less: large chunks are refused.
  constexpr std::uint64_t most_memory_bytes = std::uint64_t{4} << 30, most_file_bytes = std::uint64_t{128} << 20;
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  limit(RLIMIT_AS, most_memory_bytes);
  limit(RLIMIT_FSIZE, most_file_bytes);
  if (const Closer nothing{::open("/dev/null", O_WRONLY | O_CLOEXEC)}; nothing.descriptor >= 0) {
    ::dup2(nothing.descriptor, STDOUT_FILENO);
    ::dup2(nothing.descriptor, STDERR_FILENO);
  }
  Folders folders;
  for (const char* places : {libraries, process_and_machine, names_and_certificates}) {
    for (std::string& place : split(places, ' ')) folders.to_read.push_back(std::move(place));
  }
  for (const char* variable : {"SSL_CERT_FILE", "LD_LIBRARY_PATH"}) {
    const char* list = std::getenv(variable);
    for (std::string& place : split(list != nullptr ? list : "", ':')) folders.to_read.push_back(std::move(place));
  }
  std::string lacking;
  if (const int problem = allow_files(folders, true)) lacking = std::string("Landlock (") + std::strerror(problem) + ")";
  if (const int problem = load(filter_with_network))
    lacking += (lacking.empty() ? "" : ", ") + std::string("seccomp (") + std::strerror(problem) + ")";
  return lacking;
}

void close_cage() {
  ::dup2(STDOUT_FILENO, STDERR_FILENO);
  load(no_more_programs);
}
#endif

void check_within_cage(const std::string& file) {
  // access checks the file's permission alone, open the sandbox's as well.
  if (::access(file.c_str(), R_OK) != 0) return;
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor >= 0) {
    ::close(descriptor);
  } else if (errno == EACCES) {
    throw LoadError("needs '" + file +
                    "', which lies outside of the folder where palpa-read may read; put it there, or name its "
                    "folder in the variable PALPA_READER_FOLDERS");
  }
}

}  // namespace palpa::reader
