#pragma once
/// What the two output streams can do: colours, width, redrawing in place.

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services::cli {

/// Colours for one stream: none when it is no terminal, when NO_COLOR is set (no-color.org) or TERM is "dumb".
class Palette {
 public:
  explicit Palette(bool coloured) : coloured_(coloured) {}
  static Palette for_stream(std::FILE* stream);

  [[nodiscard]] std::string bold(std::string_view text) const { return wrap("1", text); }
  [[nodiscard]] std::string dim(std::string_view text) const { return wrap("2", text); }
  [[nodiscard]] std::string red(std::string_view text) const { return wrap("31", text); }
  [[nodiscard]] std::string green(std::string_view text) const { return wrap("32", text); }
  [[nodiscard]] std::string yellow(std::string_view text) const { return wrap("33", text); }

 private:
  [[nodiscard]] std::string wrap(std::string_view code, std::string_view text) const;
  bool coloured_;
};

/// Columns that `text` takes: code points, without escape sequences.
[[nodiscard]] std::size_t display_width(std::string_view text);

/// The first `columns` columns of one line, "…" in place of the rest; escape sequences are kept whole.
[[nodiscard]] std::string clip(std::string_view line, std::size_t columns);

/// The text in lines of at most so many columns, broken at blanks where possible; one line, possibly empty, at least. A
/// text that is coloured as a whole stays so on every line.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

/// Shows one text after the other in the same place of a terminal; on anything else, one below the other.
class Screen {
 public:
  explicit Screen(std::FILE* stream);
  /// `text`: lines, each ended by '\n'. Returns false when nobody reads any more.
  bool show(std::string_view text);

 private:
  std::FILE* stream_;
  bool terminal_;
  std::size_t lines_ = 0;  ///< that the last text took
};

}  // namespace hecaton::services::cli
