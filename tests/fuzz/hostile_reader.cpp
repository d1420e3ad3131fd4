// Hostile stand-in for palpa-read: runs the acts of the file $PALPA_HOSTILE.
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "palpa/file/protocol.h"
#include "tests/fuzz/hostile_acts.h"

int main() {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // no endless act survives a killed campaign
  using palpa::fuzz::Act;
  const char* file = std::getenv("PALPA_HOSTILE");
  std::ifstream acts(file != nullptr ? file : "", std::ios::binary);
  const int socket = palpa::protocol::socket_descriptor;
  int memory = -1;
  while (const auto act = palpa::fuzz::next_act(acts)) {
    switch (act->kind) {
      case Act::send: ::send(socket, act->bytes.data(), act->bytes.size(), MSG_NOSIGNAL); break;
      case Act::receive: {
        bool garbled = false;
        if (const auto received = palpa::protocol::receive(socket, garbled)) memory = received->descriptor;
        break;
      }
      case Act::fill: {
        const off_t size = ::lseek(memory, 0, SEEK_END);
        if (size <= 0) break;
        void* room = ::mmap(nullptr, static_cast<std::size_t>(size), PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
        if (room == MAP_FAILED) break;
        for (off_t n = 0; n < size; ++n)
          static_cast<char*>(room)[n] = act->bytes.empty() ? '\0' : act->bytes[static_cast<std::size_t>(n) % act->bytes.size()];
        break;
      }
      case Act::shrink:
        if (::ftruncate(memory, 1) == 0) return 3;  // must not be possible
        break;
      case Act::close: ::close(socket); break;
      case Act::spin:
        for (volatile bool goes_on = true; goes_on;) {
        }
        break;
      case Act::hang: ::pause(); break;
      case Act::crash: std::signal(SIGSEGV, SIG_DFL), std::raise(SIGSEGV); break;
    }
  }
  return 0;
}
