// Addresses of data that a server gives by HTTP, where else the path of a file stands.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpa {

/// Whether a path begins with http:// or https://. Any thread.
bool is_web_address(const std::filesystem::path& path) noexcept;

namespace detail {

/// Fault of an address that `is_web_address` takes for one, with what would be right; empty: none. It must have a host and no
/// user, password, query, fragment, "..", or character outside of those of an address. Any thread.
std::string problem_with_web_address(std::string_view address);

/// `std::filesystem::absolute`, made normal if wanted; an address as it is.
std::filesystem::path absolute_place(const std::filesystem::path& path, bool normal = false);

}  // namespace detail
}  // namespace palpa
