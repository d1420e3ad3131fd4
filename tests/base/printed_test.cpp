// Parts of sentences, tables and pages.
#include "palpa/base/printed.h"

#include <gtest/gtest.h>

#include <string>

#include "palpa/base/escaped.h"
#include "palpa/base/utf8.h"

namespace palpa::detail {
namespace printed_test {

TEST(Printed, CutsNothingOff) {
  EXPECT_EQ(text("%.3f N", 1.25), "1.250 N");
  EXPECT_EQ(text("%s", std::string(3000, 'a').c_str()), std::string(3000, 'a'));
  EXPECT_EQ(text("%s", ""), "");
}

TEST(Printed, PartsThousands) {
  EXPECT_EQ(grouped("0"), "0");
  EXPECT_EQ(grouped("999"), "999");
  EXPECT_EQ(grouped("-125000"), "-125 000");
  EXPECT_EQ(grouped("-125"), "-125");
  EXPECT_EQ(grouped("1234567", ","), "1,234,567");
  EXPECT_EQ(grouped("inf"), "inf");
}

TEST(Utf8, KnowsWhatIsNone) {
  EXPECT_EQ(utf8_length(""), 0u);
  EXPECT_EQ(utf8_length("a"), 1u);
  EXPECT_EQ(utf8_length("\u00e9"), 2u);
  EXPECT_EQ(utf8_length("\u20ac"), 3u);
  EXPECT_EQ(utf8_length("\U0001f600"), 4u);
  for (const char* none :
       {"\x80", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf0\x80\x80\xaf", "\xf4\x90\x80\x80", "\xe2\x82"}) {
    EXPECT_EQ(utf8_length(none), 0u) << none;
  }
}

TEST(Escaped, IsTextWithinXml) {
  EXPECT_EQ(escaped("<a b=\"c\"> & d's"), "&lt;a b=&quot;c&quot;&gt; &amp; d's");
  EXPECT_EQ(escaped("a\x1b[0m\n\tb\x7f"), "a [0m\n\tb ");
  EXPECT_EQ(escaped("\u00e9\xff\u20ac"), "\u00e9?\u20ac");
}

}  // namespace printed_test
}  // namespace palpa::detail
