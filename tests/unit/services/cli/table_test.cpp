#include "services/cli/table.hpp"

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

TEST(Table, KnowsThatItIsEmpty) {
  Table table({{"arm"}});
  EXPECT_TRUE(table.empty());
  table.add({"x"});
  EXPECT_FALSE(table.empty());
}

}  // namespace
}  // namespace hecaton::services::cli
