#pragma once
/// Text in aligned columns.

#include <cstdint>
#include <string>
#include <vector>

#include "services/cli/terminal.hpp"

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
  /// Titles and rows, a line each; columns are as wide as their widest cell, two blanks apart, nothing behind the last.
  [[nodiscard]] std::string text(const Palette& palette) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace hecaton::services::cli
