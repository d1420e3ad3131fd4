// Tokens that let hands and viewers in.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpa::app {

using AccessToken = std::array<std::uint8_t, 16>;

/// From the system's source of random numbers. Throws LoadError if it has none.
AccessToken random_token();
/// 26 digits and letters without I, L, O, U, in groups of four: "7Q4K-M0ZE-…".
std::string format_token(const AccessToken& token);
/// In upper or lower case, with or without hyphens; I and L are 1, O is 0. Throws LoadError without the text: it may be a
/// secret with an error in it.
/// \param place  begins the message: "--token"
AccessToken parsed_token(std::string_view text, const std::string& place);
/// Compares in a time that depends on neither.
bool are_equal(const AccessToken& one, const AccessToken& other) noexcept;

/// Rights of a data's side.
struct AccessTokens {
  AccessToken touch{}, watch{};
};
/// Two random ones.
AccessTokens random_tokens();
/// Tokens in a file of two lines, "touch TOKEN" and "watch TOKEN"; written with random ones if it is not there. Throws
/// LoadError, also if anyone but its owner, this user, has a right to it.
AccessTokens kept_tokens(const std::filesystem::path& file);

/// Token of a hand: of the option if given, of $PALPA_TOKEN, or asked for on the terminal. Throws LoadError.
AccessToken token_for(const std::string& given);

}  // namespace palpa::app
