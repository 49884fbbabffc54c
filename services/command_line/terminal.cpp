#include "services/command_line/terminal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <sys/ioctl.h>
#include <unistd.h>

namespace hecaton::services::cli {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kNarrowest = 12;  // of a column of text that stays readable

struct Size {
  std::size_t rows;
  std::size_t columns;
};

Size terminal_size(std::FILE* stream) {
  winsize size{};
  if (ioctl(fileno(stream), TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {24, 80};
  return {size.ws_row, size.ws_col};
}

bool starts_character(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
}

/// Length of the escape sequence "ESC [ … letter" that `text` begins with; 0 when it begins with none.
std::size_t escape_length(std::string_view text) {
  if (!text.starts_with("\x1b[")) return 0;
  std::size_t end = 2;
  while (end < text.size() && (text[end] < '@' || text[end] > '~')) ++end;
  return std::min(end + 1, text.size());
}

}  // namespace

bool is_terminal(std::FILE* stream) {
  if (isatty(fileno(stream)) == 0) return false;
  const char* term = std::getenv("TERM");
  return term == nullptr || std::string_view(term) != "dumb";
}

std::size_t terminal_columns(std::FILE* stream) {
  return terminal_size(stream).columns;
}

std::string decimal_text(double value, int digits) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.*f", digits, value);
  return buffer.data();
}

std::string duration_text(double seconds) {
  if (!(seconds >= 0.0)) return "never";
  if (seconds == 0.0) return "0 s";
  if (seconds < 0.9995e-3) return decimal_text(seconds * 1e6, 0) + " µs";
  if (seconds < 0.0995) return decimal_text(seconds * 1e3, 0) + " ms";
  if (seconds < 9.995) return decimal_text(seconds, 2) + " s";
  if (seconds < 119.5) return decimal_text(seconds, 0) + " s";
  const double whole = std::round(seconds);
  if (whole < 7200.0)
    return decimal_text(std::floor(whole / 60.0), 0) + " min " + decimal_text(std::fmod(whole, 60.0), 0) + " s";
  return decimal_text(std::floor(whole / 3600.0), 0) + " h " +
         decimal_text(std::floor(std::fmod(whole, 3600.0) / 60.0), 0) + " min";
}

std::string distance_text(double metres) {
  if (!std::isfinite(metres)) return "–";
  const double size = std::abs(metres);
  if (size >= 0.9995) return decimal_text(metres, 2) + " m";
  if (size >= 0.00995) return decimal_text(metres * 1e3, 0) + " mm";
  return decimal_text(metres * 1e3, 1) + " mm";
}

std::string bytes_text(double bytes) {
  return decimal_text(bytes * 1e-6, 1) + " MB";
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-./:=@%+,";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string percent_text(double part, double whole) {
  if (!(whole > 0.0)) return "–";
  return decimal_text(100.0 * part / whole, 1) + " %";
}

Palette Palette::for_stream(std::FILE* stream) {
  const char* no_color = std::getenv("NO_COLOR");
  const bool refused = no_color != nullptr && *no_color != '\0';
  return Palette(!refused && is_terminal(stream));
}

std::string Palette::wrap(std::string_view code, std::string_view text) const {
  if (!coloured_ || text.empty()) return std::string(text);
  return "\x1b[" + std::string(code) + "m" + std::string(text) + "\x1b[0m";
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    if (const std::size_t escape = escape_length(text); escape > 0) {
      text.remove_prefix(escape);
      continue;
    }
    if (starts_character(text.front())) ++width;
    text.remove_prefix(1);
  }
  return width;
}

std::string clip(std::string_view line, std::size_t columns) {
  if (columns == 0) return {};
  if (display_width(line) <= columns) return std::string(line);
  std::string kept;
  std::size_t width = 0;
  bool cut = false;
  while (!line.empty()) {
    if (const std::size_t escape = escape_length(line); escape > 0) {
      kept += line.substr(0, escape);
      line.remove_prefix(escape);
      continue;
    }
    if (starts_character(line.front())) {
      ++width;
      if (width == columns) kept += "…";
      cut = width >= columns;
    }
    if (!cut) kept += line.front();
    line.remove_prefix(1);
  }
  return kept;
}

std::vector<std::string> wrapped(std::string_view text, std::size_t columns) {
  if (columns == 0 || display_width(text) <= columns) return {std::string(text)};
  const std::string_view code = text.substr(0, escape_length(text));
  constexpr std::string_view kReset = "\x1b[0m";
  text.remove_prefix(code.size());
  if (!code.empty() && text.ends_with(kReset)) text.remove_suffix(kReset.size());

  std::vector<std::string> lines;
  while (!text.empty()) {
    std::size_t end = 0;    // of the part that fits
    std::size_t blank = 0;  // the last one before `end`
    for (std::size_t width = 0; end < text.size(); ++end) {
      if (!starts_character(text[end])) continue;
      if (text[end] == ' ') blank = end;
      if (width++ == columns) break;
    }
    if (end < text.size() && blank > 0) end = blank;
    lines.push_back(std::string(code) + std::string(text.substr(0, end)) + std::string(code.empty() ? "" : kReset));
    text.remove_prefix(end);
    while (text.starts_with(' ')) text.remove_prefix(1);
  }
  return lines;
}

std::vector<std::size_t> Table::widths(std::size_t widest) const {
  std::vector<std::size_t> widths;
  std::size_t total = kGap * (columns_.size() - 1);
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = display_width(columns_[c].title);
    for (const auto& row : rows_) {
      if (c < row.size()) width = std::max(width, display_width(row[c]));
    }
    widths.push_back(width);
    total += width;
  }
  while (total > widest) {
    std::size_t* largest = nullptr;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const bool can_shrink =
          columns_[c].align == Align::kLeft && widths[c] > std::max(kNarrowest, display_width(columns_[c].title));
      if (can_shrink && (largest == nullptr || widths[c] > *largest)) largest = &widths[c];
    }
    if (largest == nullptr) break;
    --*largest;
    --total;
  }
  return widths;
}

std::string Table::text(const Palette& palette, std::size_t widest) const {
  if (columns_.empty()) return {};
  const std::vector<std::size_t> width = widths(widest);
  std::string out;
  const auto add_row = [&](const auto& cell_of) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      height = std::max(height, cells.emplace_back(wrapped(cell_of(c), width[c])).size());
    }
    for (std::size_t i = 0; i < height; ++i) {
      std::string line;
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        const std::string cell = i < cells[c].size() ? cells[c][i] : std::string();
        const std::string blanks(width[c] - std::min(width[c], display_width(cell)), ' ');
        if (c > 0) line.append(kGap, ' ');
        line += columns_[c].align == Align::kRight ? blanks + cell : cell + blanks;
      }
      line.erase(line.find_last_not_of(' ') + 1);
      out += line + '\n';
    }
  };
  add_row([&](std::size_t c) { return palette.bold(columns_[c].title); });
  for (const auto& row : rows_) {
    add_row([&](std::size_t c) { return c < row.size() ? row[c] : std::string(); });
  }
  return out;
}

Screen::Screen(std::FILE* stream) : stream_(stream), terminal_(is_terminal(stream)) {}

bool Screen::show(std::string_view text) {
  std::string out;
  if (terminal_) {
    // Moves the cursor to the beginning of the last text. Each line is cleared as it is rewritten: nothing flickers.
    if (lines_ > 0) out += "\x1b[" + std::to_string(lines_) + "A";
    const Size size = terminal_size(stream_);
    lines_ = 0;
    while (!text.empty() && lines_ + 1 < size.rows) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      out += clip(text.substr(0, end), size.columns) + "\x1b[K\n";
      text.remove_prefix(std::min(end + 1, text.size()));
      ++lines_;
    }
    out += "\x1b[J";
  } else {
    out = text;
  }
  return std::fwrite(out.data(), 1, out.size(), stream_) == out.size() && std::fflush(stream_) == 0;
}

}  // namespace hecaton::services::cli
