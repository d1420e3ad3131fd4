// Whether a request to open a WebSocket may be granted.
#pragma once

#include <boost/beast/http.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::net {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;

/// Reason against a request that reached one of `hosts`; empty: it is granted. Its Host must be one of them or a loopback name,
/// with any port, because a tunnel may have another; its Origin absent, or of that very host and port: other pages of a browser
/// do not come in.
/// \param hosts  lower case, IPv6 in brackets
std::string problem_with(const Request& request, const std::vector<std::string>& hosts);

/// Host in lower case without its port: "[::1]:4711" is "[::1]".
std::string host_without_port(std::string_view host);

}  // namespace palpa::net
