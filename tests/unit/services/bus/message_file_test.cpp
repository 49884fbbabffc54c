#include "services/bus/message_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::bus {
namespace {

class MessageFile : public ::testing::Test {
 protected:
  ~MessageFile() override { std::filesystem::remove(path_); }
  static msg::WorldMemory memory(double time) {
    msg::WorldMemory message;
    message.cell("cell");
    message.time(time);
    message.obstacles().emplace_back().name("crate");
    return message;
  }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("message_file_test-" + std::to_string(getpid()))).string();
};

TEST_F(MessageFile, MissingIsNoError) {
  const ReadMessage read = read_message(path_);
  EXPECT_FALSE(read.message);
  EXPECT_EQ(read.error, "");
}

TEST_F(MessageFile, GivesBackWhatWasWrittenLast) {
  EXPECT_EQ(write_message(path_, memory(1.5)), "");
  EXPECT_EQ(write_message(path_, memory(2.5)), "");
  const ReadMessage read = read_message(path_);
  ASSERT_TRUE(read.message) << read.error;
  EXPECT_EQ(*read.message, memory(2.5));
  EXPECT_FALSE(std::filesystem::exists(path_ + ".next"));
}

TEST_F(MessageFile, AnyDamageIsNoticed) {
  ASSERT_EQ(write_message(path_, memory(1.5)), "");
  std::ifstream file(path_, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  for (std::size_t size = 1; size < whole.size(); ++size) {
    std::ofstream(path_, std::ios::binary) << whole.substr(0, size);
    EXPECT_EQ(read_message(path_).error, path_ + " is damaged") << size;
  }
  std::ofstream(path_, std::ios::binary) << whole << 'x';
  EXPECT_EQ(read_message(path_).error, path_ + " is damaged");
}

TEST_F(MessageFile, WhatCannotBeRenewedIsNotTakenForTheNewest) {
  ASSERT_EQ(write_message(path_, memory(1.5)), "");
  ASSERT_TRUE(std::filesystem::create_directory(path_ + ".next"));
  EXPECT_EQ(write_message(path_, memory(2.5)), path_ + " cannot be written: Is a directory");
  std::filesystem::remove(path_ + ".next");
  EXPECT_EQ(read_message(path_).error, path_ + " is empty: it could not be written the last time");
}

}  // namespace
}  // namespace hecaton::bus
