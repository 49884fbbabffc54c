#include "services/command_line/terminal.hpp"

#include <algorithm>
#include <cstdlib>

#include <sys/ioctl.h>
#include <unistd.h>

namespace hecaton::services::cli {
namespace {

bool is_terminal(std::FILE* stream) {
  if (isatty(fileno(stream)) == 0) return false;
  const char* term = std::getenv("TERM");
  return term == nullptr || std::string_view(term) != "dumb";
}

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
    std::size_t end = 0;    // of what fits
    std::size_t blank = 0;  // the last one that a line may end before
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

Screen::Screen(std::FILE* stream) : stream_(stream), terminal_(is_terminal(stream)) {}

bool Screen::show(std::string_view text) {
  std::string out;
  if (terminal_) {
    // Up to where the last text began; every line is cleared to its end as it is rewritten, so nothing flickers.
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
