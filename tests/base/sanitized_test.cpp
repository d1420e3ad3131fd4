// Text on terminals and pages: no character of untrusted text controls them.
#include "palpa/base/sanitized.h"

#include <gtest/gtest.h>

#include <random>

#include "palpa/base/escaped.h"
#include "palpa/base/utf8.h"

namespace palpa::detail {
namespace shown_test {

TEST(Shown, SteeringCharactersAreSpelled) {
  EXPECT_EQ(sanitized("a\033[31mb\a\n\t\x7f"), "a\\u001B[31mb\\u0007\\u000A\\u0009\\u007F");
  EXPECT_EQ(sanitized("\u009b31m"), "\\u009B31m");  // C1: as good as ESC [
  EXPECT_EQ(sanitized("file\u202etxt.exe\u2069"), "file\\u202Etxt.exe\\u2069");
  EXPECT_EQ(sanitized("\u200f\u061c\u2028"), "\\u200F\\u061C\\u2028");
  EXPECT_EQ(sanitized(std::string_view("a\0b", 3)), "a\\u0000b");
  EXPECT_EQ(sanitized("\x9b"), "\uFFFD") << "C1 in one byte, for a terminal that is not of UTF-8";
  EXPECT_EQ(sanitized("two\nlines\tof\033text", true), "two\nlines\tof\\u001Btext");
}

TEST(Shown, AllElseStaysAsItIs) {
  for (const char* text : {"", "Doe^Jane", "Straße 5 µm · 3 × 4 — „so“ …", "\u05d0\u0628", "\U0001F9E0", "C:\\new"})
    EXPECT_EQ(sanitized(text), text);
}

TEST(Shown, OfAnyBytesNothingSteersAndCleaningTwiceIsCleaningOnce) {
  std::mt19937 random(1);
  for (int n = 0; n < 20'000; ++n) {
    std::string bytes(random() % 40, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % 3 == 0 ? random() : 0x80 + random() % 0x60);
    if (n % 2 == 0) bytes.insert(random() % (bytes.size() + 1), "\u202e");
    const std::string clean = sanitized(bytes);
    EXPECT_EQ(sanitized(clean), clean);
    const std::string markup = escaped(bytes);
    for (const std::string_view text : {std::string_view(clean), std::string_view(markup)}) {
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = utf8_length(text.substr(at));
        ASSERT_GT(length, 0U);
        if (text[at] != '\n' && text[at] != '\t') {
          ASSERT_EQ(steering_length(text.substr(at)), 0U);
        }
        at += length;
      }
    }
  }
}

TEST(Shown, LongTextsLoseTheirMiddle) {
  EXPECT_EQ(shortened("0123456789", 10), "0123456789");
  EXPECT_EQ(shortened("01234567890", 9), "012…890");
  std::string umlauts;
  for (int n = 0; n < 500; ++n) umlauts += n % 3 == 0 ? "ä" : n % 3 == 1 ? "…" : "x";
  for (std::size_t most = 10; most < 600; ++most) {
    const std::string cut = shortened(umlauts, most);
    EXPECT_LE(cut.size(), most);
    EXPECT_GE(cut.size() + 8, most);
    EXPECT_EQ(sanitized(cut), cut) << "whole characters";
  }
}

}  // namespace shown_test
}  // namespace palpa::detail
