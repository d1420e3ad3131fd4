#include "palpa/file/fetch_process.h"

#include <unistd.h>

#include <algorithm>
#include <system_error>

#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/web_address.h"
#include "palpa/file/store_protocol.h"

namespace palpa::detail {

std::unique_ptr<ReaderProcess> start_fetch(const std::filesystem::path& store, const ReadOptions& options) {
  if (!is_web_address(store)) return nullptr;
  if (const std::string problem = problem_with_web_address(store.string()); !problem.empty()) throw LoadError(problem);
  std::filesystem::path program = find_reader(options.reader);
  program.replace_filename("palpa-fetch");
  std::error_code none;
  if (!std::filesystem::is_regular_file(program, none) || ::access(program.c_str(), X_OK) != 0)
    throw LoadError("cannot be fetched: the program palpa-fetch is not beside palpa-read; build it, which needs libcurl");
  auto fetch = std::make_unique<ReaderProcess>(program, idle_limit_s(store, options), options.stop);
  protocol::Request ask;
  ask.path = store.string(), ask.store = true;
  fetch->send(ask);
  return fetch;
}

double idle_limit_s(const std::filesystem::path& store, const ReadOptions& options) noexcept {
  constexpr double more_s = 15.0;  // More: a hung reader lasts longer; less: a busy machine ends a sound one
  return is_web_address(store) ? std::max(options.idle_limit_s, protocol::longest_fetch_s + more_s) : options.idle_limit_s;
}

void refuse_web_address(const std::filesystem::path& place, const std::string& what) {
  if (!is_web_address(place)) return;
  throw LoadError(one_line(place.string()) + ": is served by HTTP, which is for reading alone; " + what +
                  " takes a folder: run it where the files lie");
}

}  // namespace palpa::detail
