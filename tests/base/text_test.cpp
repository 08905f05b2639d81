// Text from files, made safe to print on a terminal.
#include "host/base/text.h"

#include <string>

#include <gtest/gtest.h>

#include "host/base/display_width.h"

namespace fascicle::tests {
namespace {

using base::shown_lines;
using base::shown_text;

TEST(ShownText, LeavesWhatIsHarmless) {
  for (const char* text : {"", "Armature|walk", "L\u00f6we \u718a \U0001f43b", "a\\b", "\u0645"})
    EXPECT_EQ(shown_text(text), text);
}

TEST(ShownText, EscapesWhatATerminalObeys) {
  EXPECT_EQ(shown_text("a\x1b[31mred"), "a\\x1b[31mred");
  EXPECT_EQ(shown_text("two\nlines\r\tand a bell\x07"), "two\\nlines\\r\\tand a bell\\x07");
  EXPECT_EQ(shown_text(std::string("nul\0", 4)), "nul\\x00");
  EXPECT_EQ(shown_text("\x7f"), "\\u007f");
  // CSI and NEL from the C1 controls; line and paragraph separators.
  EXPECT_EQ(shown_text("\u009b31m\u0085\u2028\u2029"), "\\u009b31m\\u0085\\u2028\\u2029");
}

TEST(ShownText, EscapesWhatTurnsTheDirectionOfText) {
  for (const char32_t c : {0x61cu, 0x200eu, 0x200fu, 0x202au, 0x202bu, 0x202cu, 0x202du, 0x202eu, 0x2066u,
                           0x2067u, 0x2068u, 0x2069u})
    EXPECT_TRUE(base::is_obeyed(c)) << static_cast<unsigned>(c);
  EXPECT_EQ(shown_text("gpj\u202eexe"), "gpj\\u202eexe");
  EXPECT_EQ(shown_text("\u2066a\u2069"), "\\u2066a\\u2069");
}

TEST(ShownText, EscapesWhatIsNoUtf8) {
  EXPECT_EQ(shown_text("\xff"), "\\xff");
  EXPECT_EQ(shown_text("\xc3"), "\\xc3");
  EXPECT_EQ(shown_text("\xc3("), "\\xc3(");
  // Overlong encodings of / and U+0000, a UTF-16 surrogate, and a value beyond the last code point.
  EXPECT_EQ(shown_text("\xc0\xaf"), "\\xc0\\xaf");
  EXPECT_EQ(shown_text("\xe0\x80\x80"), "\\xe0\\x80\\x80");
  EXPECT_EQ(shown_text("\xf0\x80\x80\x80"), "\\xf0\\x80\\x80\\x80");
  EXPECT_EQ(shown_text("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(shown_text("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(ShownText, IsShownAsItIs) {
  const std::string once = shown_text("a\x1b\n\u202e\xff");
  EXPECT_EQ(shown_text(once), once);
}

TEST(ShownText, LinesStayLines) {
  EXPECT_EQ(shown_lines("a\tb\x1b\nc\n"), "a\tb\\x1b\nc\n");
}

TEST(DisplayWidth, IsWhatATerminalShows) {
  using base::display_width;
  EXPECT_EQ(display_width(""), 0u);
  EXPECT_EQ(display_width("spine.x"), 7u);
  EXPECT_EQ(display_width("h\u00fcfte.x"), 7u);
  EXPECT_EQ(display_width("fu\u00df_L"), 5u);
  // macOS takes letters apart: u and two dots above.
  EXPECT_EQ(display_width("hu\u0308fte.x"), 7u);
  EXPECT_EQ(display_width("\u5de6\u8155_L"), 6u);
  EXPECT_EQ(display_width("\u304b\u3099"), 2u);
  EXPECT_EQ(display_width("\ud55c\u5b57"), 4u);
  EXPECT_EQ(display_width("\xff"), 1u);
}

}  // namespace
}  // namespace fascicle::tests
