// The checker finds each planted fault.
#include "tests/report/markup.h"

#include <gtest/gtest.h>

namespace palpa {
namespace markup_test {

TEST(Markup, WhatIsWellFormedPasses) {
  EXPECT_EQ(markup_error("<a b=\"1\"><c/>x &amp; y<d>z</d></a>\n", false), "");
  EXPECT_EQ(markup_error("<!DOCTYPE html>\n<html><style>a > b { }</style><img src=\"x\"></html>", true), "");
}

TEST(Markup, FaultsAreSeen) {
  for (const char* fault :
       {"<a>", "</a>", "<a></b>", "<a><b></a></b>", "<a>&</a>", "<a>& b;</a>", "<a b=1/>", "<a b=\"1\" b=\"2\"/>",
        "<a b=\"<\"/>", "<a/><b/>", "<a/>text", "<a b/>", "<a>1 > 0</a>", "<a", "<a>< b</a>"}) {
    EXPECT_NE(markup_error(fault, false), "") << fault;
  }
  EXPECT_NE(markup_error("<html></html>", true), "") << "no doctype";
}

}  // namespace markup_test
}  // namespace palpa
