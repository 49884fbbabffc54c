#include "services/command_line/terminal.hpp"

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

TEST(DurationText, ChoosesTheUnit) {
  EXPECT_EQ(duration_text(-1.0), "never");
  EXPECT_EQ(duration_text(0.0), "0 s");
  EXPECT_EQ(duration_text(250e-6), "250 µs");
  EXPECT_EQ(duration_text(0.017), "17 ms");
  EXPECT_EQ(duration_text(0.42), "0.42 s");
  EXPECT_EQ(duration_text(61.2), "61 s");
  EXPECT_EQ(duration_text(125.0), "2 min 5 s");
  EXPECT_EQ(duration_text(2 * 3600.0 + 15 * 60.0), "2 h 15 min");
}

TEST(DistanceText, ChoosesTheUnit) {
  EXPECT_EQ(distance_text(0.018), "18 mm");
  EXPECT_EQ(distance_text(-0.0032), "-3.2 mm");
  EXPECT_EQ(distance_text(1.5), "1.50 m");
}

TEST(PercentText, IsADashOfZero) {
  EXPECT_EQ(percent_text(1, 3), "33.3 %");
  EXPECT_EQ(percent_text(0, 0), "–");
}

TEST(ShellWord, QuotesWhatTheShellWouldChange) {
  EXPECT_EQ(shell_word("deploy/cells/three_puma.yaml"), "deploy/cells/three_puma.yaml");
  EXPECT_EQ(shell_word("my cell.yaml"), "'my cell.yaml'");
  EXPECT_EQ(shell_word("it's $HOME"), "'it'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(DisplayWidth, CountsCharactersWithoutEscapes) {
  EXPECT_EQ(display_width("µs – 18 mm"), 10U);
  EXPECT_EQ(display_width(Palette(true).red("fault")), 5U);
}

TEST(Clip, KeepsLinesThatFit) {
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

TEST(Palette, AddsNoEscapesWithoutColours) {
  EXPECT_EQ(Palette(false).bold("x"), "x");
}

TEST(Palette, AddsNoEscapesForAFile) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(Palette::for_stream(file).red("x"), "x");
  std::fclose(file);
}

TEST(Screen, AppendsTextsOnAStreamThatIsNoTerminal) {
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

TEST(Table, AlignsColumnsByDisplayedWidth) {
  Table table({{"arm"}, {"age", Align::kRight}, {"why"}});
  table.add({Palette(true).red("north"), "4 ms", "µ"});
  table.add({"w", "120 ms"});
  EXPECT_EQ(table.text(Palette(false)),
            "arm       age  why\n"
            "\x1b[31mnorth\x1b[0m    4 ms  µ\n"
            "w      120 ms\n");
}

TEST(Table, WrapsTextsWhenTheTableIsTooWide) {
  Table table({{"arm"}, {"age", Align::kRight}, {"why"}});
  table.add({"north", "4 ms", Palette(true).red("held: planner/north was ended by signal 9")});
  table.add({"west", "4 ms", "a goal"});
  // 30 columns: 5 + 2 + 4 + 2 leave 17 for the last.
  EXPECT_EQ(table.text(Palette(false), 30),
            "arm     age  why\n"
            "north  4 ms  \x1b[31mheld:\x1b[0m\n"
            "             \x1b[31mplanner/north was\x1b[0m\n"
            "             \x1b[31mended by signal 9\x1b[0m\n"
            "west   4 ms  a goal\n");
}

TEST(Table, BreaksWordsLongerThanTheirColumn) {
  Table table({{"why"}});
  table.add({"µ2345678901234567890"});
  EXPECT_EQ(table.text(Palette(false), 12), "why\nµ23456789012\n34567890\n");
}

}  // namespace
}  // namespace hecaton::services::cli
