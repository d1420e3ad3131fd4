// Formatting of numbers, texts and suggestions in errors and in TOML.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::detail {

/// Shortest decimal that parses to an equal value, in TOML's syntax ("-0.0", never "-0").
std::string toml_number(double value);
/// List of numbers: "[1, 0.5]".
std::string toml_numbers(const std::vector<double>& values);
/// TOML basic string with its quotes. Allocates; any thread.
/// \param for_no_utf8  replaces each byte of invalid UTF-8, which TOML cannot hold: U+FFFD; '?' in traces, as in version 0.1
std::string toml_string(std::string_view text, std::string_view for_no_utf8 = "\uFFFD");

/// 'text' for a message, shortened if long.
std::string in_quotes(std::string_view text);
/// The message without control characters: an error is one line for any input.
std::string one_line(std::string_view message);
/// "a, b, c".
std::string joined(std::span<const std::string> words);

/// A letter, then letters, digits, '_' or '-'.
bool is_plain_word(std::string_view word) noexcept;
/// Fault of the name of a `kind`: a plain word is required; empty: valid.
std::string problem_with_name(std::string_view kind, std::string_view name);
/// Error text for a name that another of the `kind` has.
std::string name_is_taken(std::string_view kind, std::string_view name);

/// "did you mean 'b'?" if `there` has a similar name, else "there are: a, b"; "there are none".
std::string suggestion(std::string_view name, std::span<const std::string> there);

}  // namespace palpa::detail
