// How scenes name things in errors and in TOML: one form of a number, a text and a suggestion everywhere.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::detail {

/// The shortest decimal that reads back the same, as TOML accepts it ("-0.0", never "-0").
std::string toml_number(double value);
/// A list of them: "[1, 0.5]".
std::string toml_numbers(const std::vector<double>& values);
/// A TOML basic string with its quotes. Allocates; safe from any thread.
/// \param for_no_utf8  stands for each byte that is no UTF-8, which TOML cannot hold: U+FFFD, and '?' in traces, as 0.1 wrote
/// them
std::string toml_string(std::string_view text, std::string_view for_no_utf8 = "\uFFFD");

/// 'text' for a message: shortened when long.
std::string in_quotes(std::string_view text);
/// The message without control characters: an error is one line whatever the input was.
std::string one_line(std::string_view message);
/// "a, b, c".
std::string joined(std::span<const std::string> words);

/// A letter, then letters, digits, '_' or '-'.
bool is_plain_word(std::string_view word) noexcept;
/// What is wrong with the name of a `kind` of things, which is to be a plain word; empty: nothing.
std::string problem_with_name(std::string_view kind, std::string_view name);
/// That another of the kind has the name already.
std::string name_is_taken(std::string_view kind, std::string_view name);

/// "did you mean 'b'?" where one of `there` is near to `name`, else "there are: a, b"; "there are none".
std::string suggestion(std::string_view name, std::span<const std::string> there);

}  // namespace palpa::detail
