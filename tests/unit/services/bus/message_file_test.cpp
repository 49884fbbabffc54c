#include "services/bus/message_file.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::bus {
namespace {

class MessageFile : public ::testing::Test {
 protected:
  ~MessageFile() override { std::filesystem::remove(path_); }
  static msg::WorldCheckpoint checkpoint(double time) {
    msg::WorldCheckpoint message;
    message.cell("cell");
    message.time(time);
    message.obstacles().emplace_back().name("crate");
    return message;
  }
  void write(const std::string& contents) const { std::ofstream(path_, std::ios::binary) << contents; }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("message_file_test-" + std::to_string(getpid()))).string();
};

TEST_F(MessageFile, IsEmptyWithoutErrorWhenMissing) {
  const ReadMessage read = read_message(path_);
  EXPECT_FALSE(read.message);
  EXPECT_EQ(read.error, std::nullopt);
}

TEST_F(MessageFile, ReadsWhatWasWritten) {
  for (const std::size_t padding : {0U, 1U, 65536U}) {
    write(file_contents(checkpoint(2.5)) + std::string(padding, '\0'));
    const ReadMessage read = read_message(path_);
    ASSERT_TRUE(read.message) << read.error.value_or("");
    EXPECT_EQ(*read.message, checkpoint(2.5));
  }
}

TEST_F(MessageFile, DetectsDamage) {
  const std::string whole = file_contents(checkpoint(1.5));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write(whole.substr(0, size));
    EXPECT_EQ(read_message(path_).error, path_ + " is damaged") << size;
  }
  write(whole + std::string(100, '\0') + 'x');
  EXPECT_EQ(read_message(path_).error, path_ + " is damaged");
}

}  // namespace
}  // namespace hecaton::bus
