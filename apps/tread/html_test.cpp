#include "html.hpp"

#include <gtest/gtest.h>

namespace tread {
namespace {

TEST(EscapeHtml, LeavesNoMarkup) {
  EXPECT_EQ(escape_html("<a href=\"x\">R&D's</a>"),
            "&lt;a href=&quot;x&quot;&gt;R&amp;D&#39;s&lt;/a&gt;");
  EXPECT_EQ(escape_html("one\ntwo\tm\xC2\xB2"), "one\ntwo\tm\xC2\xB2");
  EXPECT_EQ(escape_html(std::string_view("a\0b\x1B\x7F", 5)), "a&#xFFFD;b&#xFFFD;&#xFFFD;");
}

// The vectors of RFC 4648, section 10.
TEST(EncodeBase64, KnownVectors) {
  EXPECT_EQ(encode_base64(""), "");
  EXPECT_EQ(encode_base64("f"), "Zg==");
  EXPECT_EQ(encode_base64("fo"), "Zm8=");
  EXPECT_EQ(encode_base64("foo"), "Zm9v");
  EXPECT_EQ(encode_base64("foob"), "Zm9vYg==");
  EXPECT_EQ(encode_base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encode_base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(encode_base64("\xFF\xFE\xFD"), "//79");
  EXPECT_EQ(encode_base64(std::string_view("\0\0\xFB\xEF", 4)), "AAD77w==");
}

}  // namespace
}  // namespace tread
