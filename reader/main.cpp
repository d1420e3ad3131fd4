// palpa-read: opens one volume file for its caller (palpa/file/read_volume.cpp), which reports crashes in one line.
// Detects the format by the first bytes and executes its library's program: loading all libraries takes longer than most files.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "file_names.h"
#include "first_bytes.h"
#include "palpa/base/load_error.h"
#include "program.h"
#include "sandbox.h"
#include "tiff_names.h"

namespace palpa::reader {
namespace {

struct Reader {
  const char* program;
  const char* format;  ///< format within that program
};

Reader reader_of(const Beginning& file) {
#define PALPA_FORMAT(name, program, test) \
  if (test) return {"palpa-read-" #program, #name};
#define PALPA_REFUSED(test, sentence) \
  if (test) throw LoadError(sentence);
#include "formats.def"
#undef PALPA_REFUSED
#undef PALPA_FORMAT
}

void become_reader(int socket) {
  const protocol::Request request = receive_request(socket, false);
  enter_cage(request);
  const Reader reader = reader_of(Beginning(request.path));
  if (request.store && reader.format != std::string_view("zarr"))
    throw LoadError("is no OME-Zarr, whose chunks are read one by one; name the folder of one, or make one by palpa convert");
  // Others would parse all of their headers in vain.
  constexpr std::string_view with_rows[] = {"hdf5", "metaimage", "nrrd", "tiff", "vtk"};
  if (request.rows && std::ranges::find(with_rows, reader.format) == std::end(with_rows)) {
    receive_request(socket, true);  // an unread one would reset the connection
    protocol::send(socket, protocol::Header{});
    return;
  }
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").replace_filename(reader.program);
  ::execl(program.c_str(), reader.program, reader.format, nullptr);
  throw LoadError("cannot be opened: the program " + std::string(reader.program) + " beside palpa-read does not start (" +
                  std::strerror(errno) + "); build or install both anew");
}

/// Prints the parts of the sandbox that this kernel lacks, detected inside it; nothing if it lacks none.
int print_cage() {
  const int output = ::dup(STDOUT_FILENO);
  const std::string lacking = enter_cage({});
  return lacking.empty() || ::dprintf(output, "%s\n", lacking.c_str()) > 0 ? 0 : 1;
}

}  // namespace
}  // namespace palpa::reader

int main(int count, char** arguments) {
  if (count == 2 && std::string_view(arguments[1]) == "--cage") return palpa::reader::print_cage();
  return palpa::reader::run_program(palpa::reader::become_reader);
}
