// Files whose contents are replaced as a whole, also on a disk that is full by then.
#include "services/runtime/kept_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/full_disk.hpp"

namespace hecaton::services {
namespace {

constexpr off_t kPiece = 1 << 16;  // in which room is taken

class KeptFile : public ::testing::Test {
 protected:
  ~KeptFile() override {
    std::filesystem::remove(path_);
    std::filesystem::remove_all(other_file_of(path_));
  }
  [[nodiscard]] std::string keep(const std::string& contents) const { return keep_in_file(path_, contents, '\n'); }
  /// What is in the file, without its padding.
  [[nodiscard]] std::string kept() const {
    std::ifstream file(path_, std::ios::binary);
    std::string all{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    all.erase(all.find_last_not_of('\n') + 1);
    return all;
  }
  static struct stat look_at(const std::string& path) {
    struct stat seen {};
    EXPECT_EQ(stat(path.c_str(), &seen), 0) << path;
    return seen;
  }
  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("kept_file_test-" + std::to_string(getpid()))).string();
};

TEST_F(KeptFile, HasWhatWasKeptLast) {
  for (const auto* contents : {"first", "the second, which is longer", "3rd"}) {
    EXPECT_EQ(keep(contents), "");
    EXPECT_EQ(kept(), contents);
  }
}

TEST_F(KeptFile, TakesTurnsInTheRoomOfTwoFiles) {
  ASSERT_EQ(keep("first"), "");
  const auto first = look_at(path_);
  const auto other = look_at(other_file_of(path_));
  EXPECT_EQ(first.st_size, kPiece);
  EXPECT_EQ(other.st_size, kPiece) << "room for the next time";
  EXPECT_GE(other.st_blocks * 512, kPiece) << "and it is there, not promised";
  ASSERT_EQ(keep("second"), "");
  EXPECT_EQ(look_at(path_).st_ino, other.st_ino);
  ASSERT_EQ(keep("third"), "");
  EXPECT_EQ(look_at(path_).st_ino, first.st_ino);
}

// As soon as the contents outgrow one room: when the other one is needed the disk may be full.
TEST_F(KeptFile, GrowsBothFilesAtOnce) {
  ASSERT_EQ(keep("small"), "");
  ASSERT_EQ(keep(std::string(kPiece, 'x')), "");
  EXPECT_EQ(look_at(path_).st_size, 2 * kPiece);
  const auto other = look_at(other_file_of(path_));
  EXPECT_EQ(other.st_size, 2 * kPiece);
  EXPECT_GE(other.st_blocks * 512, 2 * kPiece);
  EXPECT_EQ(kept(), std::string(kPiece, 'x'));
}

TEST_F(KeptFile, OnAFullDiskWhatWasKeptStaysUntilThereIsRoomAgain) {
  const std::string large(2 * kPiece, 'x');
  const std::string refusal = path_ + " cannot be written: File too large";
  {
    const test::FullDisk full(kPiece - 1);
    EXPECT_EQ(keep("small"), refusal) << "no room was taken yet";
    EXPECT_FALSE(std::filesystem::exists(path_));
  }
  ASSERT_EQ(keep("small"), "");
  {
    const test::FullDisk full(kPiece);
    EXPECT_EQ(keep(large), refusal);
    EXPECT_EQ(kept(), "small");
    EXPECT_EQ(keep("also small"), "") << "what has room is kept";
    EXPECT_EQ(keep(large), refusal);
    EXPECT_EQ(kept(), "also small");
  }
  EXPECT_EQ(keep(large), "");
  EXPECT_EQ(kept(), large);
}

TEST_F(KeptFile, ThatCannotBeWrittenIsSaidInASentence) {
  ASSERT_EQ(keep("first"), "");
  ASSERT_TRUE(std::filesystem::remove(other_file_of(path_)));
  ASSERT_TRUE(std::filesystem::create_directory(other_file_of(path_)));
  EXPECT_EQ(keep("second"), path_ + " cannot be written: Is a directory");
  EXPECT_EQ(kept(), "first");
  const std::string nowhere = path_ + "/no/such/folder";
  EXPECT_EQ(keep_in_file(nowhere, "x", '\n'), nowhere + " cannot be written: Not a directory");
}

}  // namespace
}  // namespace hecaton::services
