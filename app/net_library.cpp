#include "app/net_library.h"

#include <dlfcn.h>

#include <charconv>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "palpa/base/load_error.h"
#include "palpa/base/own_files.h"
#include "palpa/base/wording.h"
#include "palpa/far/message.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

const Net& load_net() {
  std::error_code none;
  for (const std::filesystem::path& folder : own_files_folders()) {
    const std::filesystem::path file = folder / "palpa-net.so";
    if (!std::filesystem::exists(file, none)) continue;
    void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
      throw LoadError(detail::one_line(file.string() + ": cannot be loaded (" + ::dlerror() + "); install palpa again"));
    const auto* const found = static_cast<const Net*>(::dlsym(library, "palpa_net"));
    if (!found || std::strcmp(found->palpa_version, version) != 0)
      throw LoadError(file.string() + ": is not of this palpa, " + version + "; install palpa again");
    return *found;
  }
  throw LoadError("network: this palpa was built without it; build it with PALPA_NET=ON");
}

}  // namespace

const Net& net() {
  static const Net& loaded = load_net();
  return loaded;
}

NetPlace net_place(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  NetPlace place{.host = text.substr(0, colon)};
  const bool is_bracketed = place.host.size() > 2 && place.host.front() == '[' && place.host.back() == ']';
  if (is_bracketed) place.host = place.host.substr(1, place.host.size() - 2);
  const char* const end = text.data() + text.size();
  const bool has_port = colon != std::string::npos && std::from_chars(text.data() + colon + 1, end, place.port).ptr == end;
  if (!has_port || place.port == 0 || place.host.empty() || (!is_bracketed && place.host.find(':') != std::string::npos) ||
      place.host.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:_") != std::string::npos)
    throw LoadError("--data-at " + detail::in_quotes(text) + ": is no place; write HOST:PORT, as 127.0.0.1:4711 or [::1]:4711");
  return place;
}

bool is_loopback(const std::string& host) { return host == "localhost" || host == "127.0.0.1" || host == "::1"; }

bool may_be_lost(std::span<const std::byte> message) noexcept {
  const std::optional<MessageHead> head = head_of(message);
  return head && (head->kind == MessageHead::Kind::probes || head->kind == MessageHead::Kind::model);
}

}  // namespace palpa::app
