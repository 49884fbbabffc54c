#include "services/command_line/terminal.hpp"

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

TEST(DisplayWidth, CountsCharactersWithoutEscapes) {
  EXPECT_EQ(display_width("µs – 18 mm"), 10U);
  EXPECT_EQ(display_width(Palette(true).red("fault")), 5U);
}

TEST(Clip, KeepsWhatFits) {
  EXPECT_EQ(clip("abc", 3), "abc");
}

TEST(Clip, EndsWithAnEllipsis) {
  EXPECT_EQ(clip("abcdef", 4), "abc…");
  EXPECT_EQ(clip("aµµµµ", 3), "aµ…");
  EXPECT_EQ(clip("abc", 1), "…");
  EXPECT_EQ(clip("abc", 0), "");
}

TEST(Clip, ClosesColours) {
  EXPECT_EQ(clip("\x1b[31mabcdef\x1b[0m", 3), "\x1b[31mab…\x1b[0m");
}

TEST(Palette, IsPlainWhenAsked) {
  EXPECT_EQ(Palette(false).bold("x"), "x");
}

TEST(Palette, NoStreamButATerminalIsColoured) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(Palette::for_stream(file).red("x"), "x");
  std::fclose(file);
}

TEST(Screen, PrintsOneTextBelowTheOtherWhereItCannotRedraw) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  Screen screen(file);
  EXPECT_TRUE(screen.show("first\n"));
  EXPECT_TRUE(screen.show("second\n"));
  std::rewind(file);
  char buffer[64] = {};
  const std::size_t size = std::fread(buffer, 1, sizeof buffer, file);
  EXPECT_EQ(std::string(buffer, size), "first\nsecond\n");
  std::fclose(file);
}

}  // namespace
}  // namespace hecaton::services::cli
