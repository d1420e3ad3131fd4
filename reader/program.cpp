#include "program.h"

#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

#include "palpa/base/load_error.h"

#ifdef __SANITIZE_ADDRESS__
/// Allocations that are too large fail as without the sanitizer, so that libraries report them. The address space is unlimited;
/// the slack of serve.cpp, an eighth of it taken at once, replaces that limit.
/// Crashes in libraries, which are not sanitized, end by their signal; findings in our own code end by an exit code.
extern "C" const char* __asan_default_options() {
  return "allocator_may_return_null=1:max_allocation_size_mb=512:alloc_dealloc_mismatch=0:"
         "handle_segv=0:handle_sigbus=0:handle_sigfpe=0";
}
// The sanitizer's own would end the program instead of throwing.
void* operator new(std::size_t bytes) {
  if (void* const memory = std::malloc(bytes)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t bytes) { return ::operator new(bytes); }
#endif

namespace palpa::reader {

int run_program(const std::function<void(int socket)>& work) {
  const int socket = protocol::socket_descriptor;
  struct stat status {};
  if (::fstat(socket, &status) != 0 || !S_ISSOCK(status.st_mode)) {
    std::fputs("palpa: palpa-read: is started by palpa to open a file; try 'palpa info FILE'\n", stderr);
    return 2;
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  ::mallopt(M_ARENA_MAX, 2);  // each arena reserves address space

  std::string sentence;
  try {
    work(socket);
  } catch (const std::bad_alloc&) {
    sentence = "needs more memory to be read than its header says; it is probably damaged";
  } catch (const std::length_error&) {
    sentence = "claims more than memory can hold; its header is damaged";
  } catch (const LoadError& error) {
    sentence = error.what();
  } catch (const std::exception& error) {
    sentence = std::string("cannot be read (") + error.what() + "); check that the file is whole";
  }
  if (!sentence.empty()) {
    // Unread packets would reset the connection before the caller has read the error: read them first.
    for (char packet; ::recv(socket, &packet, sizeof packet, MSG_DONTWAIT) > 0;) continue;
    protocol::send(socket, protocol::Failure{sentence});
  }
  ::_exit(sentence.empty() ? 0 : 1);  // Skips static destructors.
}

protocol::Request receive_request(int socket, bool take, int* unpacked) {
  bool garbled = false;
  const auto first = protocol::receive(socket, garbled, take);
  if (!first || !std::holds_alternative<protocol::Request>(first->message)) {
    throw LoadError("was asked for in a way that palpa-read does not know; update palpa and palpa-read together");
  }
  if (unpacked != nullptr) *unpacked = first->descriptor;
  return std::get<protocol::Request>(first->message);
}

}  // namespace palpa::reader
