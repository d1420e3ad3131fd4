#include "app/access_token.h"

#include <sys/random.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>

#include "app/terminal.h"
#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view digits = "0123456789ABCDEFGHJKMNPQRSTVWXYZ";  // Crockford's base 32
constexpr std::size_t length = 26;                                       // [1] of them, for 128 bits

/// Number of a digit; 32: none.
std::uint8_t number_of(char c) {
  if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  if (c == 'I' || c == 'L') c = '1';
  if (c == 'O') c = '0';
  const std::size_t at = digits.find(c);
  return at == std::string_view::npos ? 32 : static_cast<std::uint8_t>(at);
}

/// Only its owner has rights to a file that is created in this object's lifetime.
class OwnFiles {
 public:
  OwnFiles() : before_(::umask(0077)) {}
  ~OwnFiles() { ::umask(before_); }
  OwnFiles(const OwnFiles&) = delete;
  OwnFiles& operator=(const OwnFiles&) = delete;

 private:
  mode_t before_;
};

/// Words typed in a terminal, without echo.
std::string asked(const std::string& prompt) {
  termios before{};
  ::tcgetattr(STDIN_FILENO, &before);
  termios silent = before;
  silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  tell(prompt);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent);
  std::string line;
  std::getline(std::cin, line);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  tell("\n");
  return line;
}

}  // namespace

AccessToken random_token() {
  AccessToken token;
  if (::getrandom(token.data(), token.size(), 0) != static_cast<ssize_t>(token.size()))
    throw LoadError("token: the system gives no random numbers; try again");
  return token;
}

std::string format_token(const AccessToken& token) {
  std::string text;
  for (std::size_t n = 0; n < length; ++n) {
    if (n > 0 && n % 4 == 0) text += '-';
    unsigned value = 0;
    for (std::size_t bit = 5 * n; bit < 5 * n + 5; ++bit)  // the last two digits' bits beyond 128 are 0
      value = 2 * value + (bit < 128 ? token[bit / 8] >> (7 - bit % 8) & 1u : 0u);
    text += digits[value];
  }
  return text;
}

AccessToken parsed_token(std::string_view text, const std::string& place) {
  AccessToken token{};
  std::size_t n = 0;
  for (const char c : text) {
    if (c == '-' || c == ' ' || c == '\r') continue;
    const std::uint8_t value = number_of(c);
    if (value == 32 || n == length)
      throw LoadError(place + ": is no token; it has 26 letters and digits, as palpa serve prints");
    for (std::size_t bit = 5 * n; bit < 5 * n + 5 && bit < 128; ++bit)
      token[bit / 8] = static_cast<std::uint8_t>(token[bit / 8] | (value >> (4 - (bit - 5 * n)) & 1u) << (7 - bit % 8));
    ++n;
  }
  if (n != length) throw LoadError(place + ": is no token; it has 26 letters and digits, as palpa serve prints");
  return token;
}

bool are_equal(const AccessToken& one, const AccessToken& other) noexcept {
  volatile std::uint8_t differs = 0;
  for (std::size_t n = 0; n < one.size(); ++n) differs = static_cast<std::uint8_t>(differs | (one[n] ^ other[n]));
  return differs == 0;
}

AccessTokens random_tokens() { return {random_token(), random_token()}; }

AccessTokens kept_tokens(const fs::path& file) {
  const detail::InputFile opened(file);
  if (opened.why_not() == detail::NoInput::missing) {
    const AccessTokens tokens = random_tokens();
    const OwnFiles own;
    detail::write_whole(file, "touch " + format_token(tokens.touch) + "\nwatch " + format_token(tokens.watch) + "\n",
                        detail::Existing::refused);
    return tokens;
  }
  const std::string text =
      detail::read_whole(opened, limit::token_bytes, "name a file of tokens; one that is not there is made");
  struct stat status = {};
  if (::fstat(opened.descriptor(), &status) != 0 || (status.st_mode & 0077) != 0 || status.st_uid != ::geteuid())
    throw LoadError(file.string() + ": others have a right to the tokens in it; chmod 600, with you as its owner");
  const std::string_view kept(text);
  const std::size_t end = kept.find('\n'), next = end == std::string_view::npos ? kept.size() : end + 1;
  const std::string_view touch = kept.substr(0, end), watch = kept.substr(next, kept.find('\n', next) - next);
  if (!touch.starts_with("touch ") || !watch.starts_with("watch ") || kept.size() > next + watch.size() + 1)
    throw LoadError(file.string() +
                    ": is no file of tokens; it has two lines, touch TOKEN and watch TOKEN, or is made if not there");
  const AccessTokens tokens{parsed_token(touch.substr(6), file.string() + ":1"),
                            parsed_token(watch.substr(6), file.string() + ":2")};
  if (are_equal(tokens.touch, tokens.watch))
    throw LoadError(file.string() + ": has one token twice; leave the file out, and two are made");
  return tokens;
}

AccessToken token_for(const std::string& given) {
  if (!given.empty()) return parsed_token(given, "--token");
  if (const char* const kept = std::getenv("PALPA_TOKEN"); kept && *kept) return parsed_token(kept, "PALPA_TOKEN");
  if (::isatty(STDIN_FILENO) != 1)
    throw LoadError("token: none was given; set PALPA_TOKEN to the one that palpa serve printed, or give --token");
  return parsed_token(asked("token: "), "token");
}

}  // namespace palpa::app
