#include "services/command_line/table.hpp"

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

TEST(Table, AlignsColumnsByWhatIsSeen) {
  Table table({{"arm"}, {"age", Align::kRight}, {"why"}});
  table.add({Palette(true).red("north"), "4 ms", "µ"});
  table.add({"w", "120 ms"});
  EXPECT_EQ(table.text(Palette(false)),
            "arm       age  why\n"
            "\x1b[31mnorth\x1b[0m    4 ms  µ\n"
            "w      120 ms\n");
}

TEST(Table, BreaksLongTextsWhenItWouldBeTooWide) {
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

TEST(Table, BreaksWordsThatAreLongerThanTheirColumn) {
  Table table({{"why"}});
  table.add({"µ2345678901234567890"});
  EXPECT_EQ(table.text(Palette(false), 12), "why\nµ23456789012\n34567890\n");
}

TEST(Table, KnowsThatItIsEmpty) {
  Table table({{"arm"}});
  EXPECT_TRUE(table.empty());
  table.add({"x"});
  EXPECT_FALSE(table.empty());
}

}  // namespace
}  // namespace hecaton::services::cli
