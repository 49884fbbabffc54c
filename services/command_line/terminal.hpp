#pragma once
/// Text for people: numbers with units, tables, colours, and a screen that is redrawn in place.

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hecaton::services::cli {

/// True for a terminal that can redraw text: not when TERM is "dumb".
[[nodiscard]] bool is_terminal(std::FILE* stream);
/// Width of the terminal; 80 when it is unknown.
[[nodiscard]] std::size_t terminal_columns(std::FILE* stream);

/// "850 µs", "17 ms", "0.42 s", "2 min 5 s"; "never" for a negative value (the age of something never received).
[[nodiscard]] std::string duration_text(double seconds);
/// "18 mm", "0.418 m", "-3.2 mm"; "–" when not finite.
[[nodiscard]] std::string distance_text(double metres);
/// Fixed point.
[[nodiscard]] std::string decimal_text(double value, int digits);
/// "12.5 MB" (10⁶ bytes).
[[nodiscard]] std::string bytes_text(double bytes);
/// "97.3 %"; "–" when `whole` is 0.
[[nodiscard]] std::string percent_text(double part, double whole);

/// `text` as one word of a shell, in quotes where it needs them: a command that contains it can be copied.
[[nodiscard]] std::string shell_word(std::string_view text);

/// Colours for one stream. for_stream() disables them when the stream is no terminal, when NO_COLOR is set
/// (no-color.org) or when TERM is "dumb".
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

/// `text` in lines of at most `columns` columns, broken at blanks where possible; at least one line, possibly empty. A
/// text that is coloured as a whole stays coloured on every line.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

enum class Align : std::uint8_t { kLeft, kRight };

/// Text in aligned columns.
class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// Adds a row. Cells may hold escape sequences; missing cells are empty.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Titles and rows; columns are as wide as their widest cell and two blanks apart. A table wider than `widest`
  /// columns gets narrower columns of text, with cells of several lines.
  [[nodiscard]] std::string text(const Palette& palette, std::size_t widest = kWidest) const;

  static constexpr std::size_t kWidest = 120;

 private:
  [[nodiscard]] std::vector<std::size_t> widths(std::size_t widest) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Shows texts one after the other in the same place of a terminal; on any other stream one below the other.
class Screen {
 public:
  explicit Screen(std::FILE* stream);
  /// `text`: lines, each ended by '\n'. False: the stream cannot be written (its reader has ended).
  bool show(std::string_view text);

 private:
  std::FILE* stream_;
  bool terminal_;
  std::size_t lines_ = 0;  ///< that the last text took
};

}  // namespace hecaton::services::cli
