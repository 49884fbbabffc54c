#include "services/command_line/table.hpp"

#include <algorithm>

namespace hecaton::services::cli {
namespace {

constexpr std::size_t kGap = 2;
/// Narrower than this, a column of text is no longer readable.
constexpr std::size_t kNarrowest = 12;

}  // namespace

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

}  // namespace hecaton::services::cli
