#pragma once
/// Text in aligned columns.

#include <cstdint>
#include <string>
#include <vector>

#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {

enum class Align : std::uint8_t { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// Cells may hold escape sequences; missing ones are empty.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  /// Titles and rows; columns are as wide as their widest cell, two blanks apart, nothing behind the last. When that
  /// would be more than `widest`, the widest columns of text become narrower and their cells several lines.
  [[nodiscard]] std::string text(const Palette& palette, std::size_t widest = kWidest) const;

  static constexpr std::size_t kWidest = 120;

 private:
  [[nodiscard]] std::vector<std::size_t> widths(std::size_t widest) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace hecaton::services::cli
