#pragma once
/// What the fuzz targets share. A target is a source in targets/ with the function HECATON_FUZZ_TARGET(name). It
/// returns, or it aborts the process.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::fuzz {

using View = std::span<const std::uint8_t>;

/// Ends the process with a sentence when a property does not hold, as a crash would.
inline void require(bool holds, std::string_view sentence) {
  if (holds) return;
  std::fprintf(stderr, "broken property: %.*s\n", static_cast<int>(sentence.size()), sentence.data());
  std::abort();
}

/// A refusal must be one line that says something.
inline void require_sentence(std::string_view sentence) {
  const bool is_line = sentence.find('\n') == std::string_view::npos;
  if (!is_line || sentence.empty()) std::fprintf(stderr, "'%s'\n", std::string(sentence).c_str());
  require(is_line && !sentence.empty(), "a refusal is one line");
}

/// The input: takes values from its front. What is missing is zero or empty.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : left_(data, size) {}

  std::uint8_t byte() {
    const View one = take(1);
    return one.empty() ? 0 : one[0];
  }
  View take(std::size_t most) {
    const View front = left_.first(std::min(most, left_.size()));
    left_ = left_.subspan(front.size());
    return front;
  }
  /// Takes it from the end, so that the input may be a text file.
  std::uint8_t last_byte() {
    if (left_.empty()) return 0;
    const std::uint8_t last = left_.back();
    left_ = left_.first(left_.size() - 1);
    return last;
  }
  View rest() { return take(left_.size()); }
  [[nodiscard]] bool empty() const { return left_.empty(); }

 private:
  View left_;
};

inline std::string text_of(View bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A folder for the files of a target. It lives as long as the process.
inline const test::TemporaryFolder& folder() {
  static const test::TemporaryFolder kFolder;
  return kFolder;
}

/// The path of a file in the source tree.
inline std::string source(const std::string& path) {
  return std::string(HECATON_SOURCE_DIR) + "/" + path;
}

}  // namespace hecaton::fuzz

/// The name that libFuzzer calls; or, where a test calls all targets, one for each.
#ifdef HECATON_FUZZ_REPLAY
#define HECATON_FUZZ_TARGET(name) fuzz_##name
#else
#define HECATON_FUZZ_TARGET(name) LLVMFuzzerTestOneInput
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
#endif
