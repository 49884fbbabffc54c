#include "services/view/token_file.hpp"

#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

class TokenFile : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "view-token";
  const std::string token_ = random_token();
  const std::string watch_ = random_token();
  const std::string url_ = "https://10.0.0.2:8042/?watch=" + watch_ + "#token=" + token_;
};

TEST_F(TokenFile, IsReadableByItsUserOnly) {
  const mode_t before = ::umask(0);
  write_token_file(path_, url_);
  ::umask(before);
  struct stat about {};
  ASSERT_EQ(::stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 07777U, 0600U);
  std::ifstream file(path_);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), url_ + "\n");
  EXPECT_EQ(token_in_file(path_, kControlMarker), token_);
  EXPECT_EQ(token_in_file(path_, kWatchMarker), watch_);
}

TEST_F(TokenFile, ReplacesAFileThatOthersMayReadOrALink) {
  std::ofstream(path_) << "http://127.0.0.1:8042/#token=" << std::string(64, '0') << "\n";
  ASSERT_EQ(::chmod(path_.c_str(), 0644), 0);
  EXPECT_FALSE(token_in_file(path_, kControlMarker)) << "another user may know it";
  write_token_file(path_, url_);
  EXPECT_EQ(token_in_file(path_, kControlMarker), token_);

  std::filesystem::remove(path_);
  const std::filesystem::path elsewhere = folder_.path() / "elsewhere";
  std::ofstream(elsewhere) << "mine";
  std::filesystem::create_symlink(elsewhere, path_);
  EXPECT_FALSE(token_in_file(path_, kControlMarker));
  write_token_file(path_, url_);
  EXPECT_FALSE(std::filesystem::is_symlink(path_));
  EXPECT_EQ(std::filesystem::file_size(elsewhere), 4U);
}

TEST_F(TokenFile, HasNoTokenUnlessItIsWhole) {
  EXPECT_FALSE(token_in_file(path_, kControlMarker)) << "there is none";
  for (const std::string& text : {std::string(), url_.substr(0, url_.size() - 1), "#token=" + std::string(64, 'G')}) {
    write_token_file(path_, text);
    EXPECT_FALSE(token_in_file(path_, kControlMarker)) << text;
  }
}

TEST_F(TokenFile, SaysWhyItCannotBeWritten) {
  try {
    write_token_file(folder_.path() / "missing" / "view-token", url_);
    FAIL();
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("missing/view-token, cannot be written: No such file or directory"), std::string::npos) << text;
    EXPECT_EQ(text.find(token_), std::string::npos);
  }
}

}  // namespace
}  // namespace hecaton::services
