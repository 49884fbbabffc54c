// Files that are replaced as a whole, also on a full disk, and mapped files.
#include "services/runtime/atomic_file.hpp"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/full_disk.hpp"

namespace hecaton::services {
namespace {

constexpr off_t kPiece = 1 << 16;  // unit of the room that is reserved [byte]

class AtomicFile : public ::testing::Test {
 protected:
  ~AtomicFile() override {
    std::filesystem::remove(path_);
    std::filesystem::remove_all(spare_file_of(path_));
  }
  [[nodiscard]] std::optional<std::string> write(const std::string& text) const {
    return write_atomically(path_, text, '\n');
  }
  /// The file's contents without padding.
  [[nodiscard]] std::string contents() const {
    std::ifstream file(path_, std::ios::binary);
    std::string all{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    all.erase(all.find_last_not_of('\n') + 1);
    return all;
  }
  static struct stat status_of(const std::string& path) {
    struct stat status {};
    EXPECT_EQ(stat(path.c_str(), &status), 0) << path;
    return status;
  }
  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("atomic_file_test-" + std::to_string(getpid()))).string();
};

TEST_F(AtomicFile, HasTheLastContents) {
  for (const auto* text : {"first", "the second, which is longer", "3rd"}) {
    EXPECT_EQ(write(text), std::nullopt);
    EXPECT_EQ(contents(), text);
  }
}

TEST_F(AtomicFile, AlternatesBetweenTwoFiles) {
  ASSERT_EQ(write("first"), std::nullopt);
  const auto first = status_of(path_);
  const auto other = status_of(spare_file_of(path_));
  EXPECT_EQ(first.st_size, kPiece);
  EXPECT_EQ(other.st_size, kPiece) << "room for the next write";
  EXPECT_GE(other.st_blocks * 512, kPiece) << "and the blocks are allocated";
  ASSERT_EQ(write("second"), std::nullopt);
  EXPECT_EQ(status_of(path_).st_ino, other.st_ino);
  ASSERT_EQ(write("third"), std::nullopt);
  EXPECT_EQ(status_of(path_).st_ino, first.st_ino);
}

// When the second file is needed, the disk may be full.
TEST_F(AtomicFile, GrowsBothFilesAtOnce) {
  ASSERT_EQ(write("small"), std::nullopt);
  ASSERT_EQ(write(std::string(kPiece, 'x')), std::nullopt);
  EXPECT_EQ(status_of(path_).st_size, 2 * kPiece);
  const auto other = status_of(spare_file_of(path_));
  EXPECT_EQ(other.st_size, 2 * kPiece);
  EXPECT_GE(other.st_blocks * 512, 2 * kPiece);
  EXPECT_EQ(contents(), std::string(kPiece, 'x'));
}

TEST_F(AtomicFile, KeepsTheFormerContentsWhileTheDiskIsFull) {
  const std::string large(2 * kPiece, 'x');
  const std::string refusal = path_ + " cannot be written: File too large";
  {
    const test::FullDisk full(kPiece - 1);
    EXPECT_EQ(write("small"), refusal) << "no room is reserved yet";
    EXPECT_FALSE(std::filesystem::exists(path_));
  }
  ASSERT_EQ(write("small"), std::nullopt);
  {
    const test::FullDisk full(kPiece);
    EXPECT_EQ(write(large), refusal);
    EXPECT_EQ(contents(), "small");
    EXPECT_EQ(write("also small"), std::nullopt) << "the reserved room suffices";
    EXPECT_EQ(write(large), refusal);
    EXPECT_EQ(contents(), "also small");
  }
  EXPECT_EQ(write(large), std::nullopt);
  EXPECT_EQ(contents(), large);
}

TEST_F(AtomicFile, ReportsAFailureInASentence) {
  ASSERT_EQ(write("first"), std::nullopt);
  ASSERT_TRUE(std::filesystem::remove(spare_file_of(path_)));
  ASSERT_TRUE(std::filesystem::create_directory(spare_file_of(path_)));
  EXPECT_EQ(write("second"), path_ + " cannot be written: Is a directory");
  EXPECT_EQ(contents(), "first");
  const std::string nowhere = path_ + "/no/such/folder";
  EXPECT_EQ(write_atomically(nowhere, "x", '\n'), nowhere + " cannot be written: Not a directory");
}

class MappedFileTest : public ::testing::Test {
 protected:
  ~MappedFileTest() override { std::filesystem::remove(path_); }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_mapped_" + std::to_string(getpid()))).string();
};

TEST_F(MappedFileTest, IsZeroAtFirstAndKeepsItsContents) {
  {
    const MappedFile file(path_, 100, "it");
    const std::string zeros(100, '\0');
    EXPECT_EQ(std::memcmp(file.data(), zeros.data(), zeros.size()), 0);
    std::memcpy(file.data(), "kept", 4);
  }
  const MappedFile again(path_, 200, "it");
  EXPECT_EQ(std::memcmp(again.data(), "kept", 4), 0);
}

TEST_F(MappedFileTest, MapsNothingWithoutAPath) {
  EXPECT_EQ(MappedFile("", 100, "it").data(), nullptr);
}

TEST_F(MappedFileTest, RefusesAFullDiskWithASentence) {
  const test::FullDisk full(50);
  try {
    const MappedFile file(path_, 100, "the arm's lease");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), path_ + ": the arm's lease cannot be kept there: File too large");
  }
}

}  // namespace
}  // namespace hecaton::services
