#include "net/request.h"

#include <algorithm>
#include <boost/beast/websocket/rfc6455.hpp>

#include "net/stream.h"
#include "palpa/base/input_file.h"
#include "palpa/base/wording.h"

namespace palpa::net {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

std::string host_without_port(std::string_view host) {
  const std::size_t bracket = host.rfind(']');
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  return lower(host.substr(0, colon));
}

std::string problem_with(const Request& request, const std::vector<std::string>& hosts) {
  if (!websocket::is_upgrade(request) || request.target() != "/")
    return "the request is for a page, and there is none; connect with palpa run --data-at, or a WebSocket at /";
  if (request.count(http::field::host) != 1 || request.count(http::field::origin) > 1)
    return "the request has no single Host and Origin; connect with palpa run --data-at";
  const std::string_view host = view(request[http::field::host]);
  const std::string name = host_without_port(host);
  const bool is_ours =
      name == "localhost" || name == "127.0.0.1" || name == "[::1]" || std::ranges::find(hosts, name) != hosts.end();
  if (!is_ours)
    return "host " + detail::in_quotes(host) + " is not the name that is listened to; there are: localhost, " +
           detail::joined(hosts);
  if (request.count(http::field::origin) == 0) return {};
  const std::string origin = lower(view(request[http::field::origin]));
  if (origin == "http://" + lower(host) || origin == "https://" + lower(host)) return {};
  return "origin " + detail::in_quotes(origin) + " is a page of another host; a page has to come from " +
         detail::in_quotes(host);
}

std::string pem_file(const std::filesystem::path& file, const char* right) {
  return detail::read_whole(detail::InputFile(file), limit::pem_bytes, right);
}

}  // namespace palpa::net
