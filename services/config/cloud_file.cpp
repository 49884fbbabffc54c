#include "services/config/cloud_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "planner/model/source_file.hpp"
#include "services/config/text.hpp"
#include "world/model/point_cloud.hpp"

namespace hecaton::config {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using world::PointCloud;

/// Above the bytes of the largest cloud with many fields.
constexpr std::uintmax_t kLargestFile = 256'000'000;

[[noreturn]] void fail(const std::string& sentence) {
  throw std::invalid_argument(sentence);
}

std::string bytes_of(const std::filesystem::path& path, const std::string& name) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) fail(name + ": there is no such file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kLargestFile)
    fail(name + " must have at most " + std::to_string(kLargestFile / 1'000'000) + " MB");
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) fail(name + " cannot be read; give this user the right to read it");
  if (planner::is_lfs_pointer(bytes)) fail(name + " " + planner::kLfsPointer);
  return bytes;
}

/// Words of a line, at most `Most` of them.
template <std::size_t Most>
std::size_t split(std::string_view line, std::array<std::string_view, Most>& words) {
  std::size_t count = 0;
  std::size_t at = 0;
  while (count < Most) {
    at = line.find_first_not_of(" \t\r,;", at);
    if (at == std::string_view::npos) break;
    const std::size_t end = std::min(line.find_first_of(" \t\r,;", at), line.size());
    words[count++] = line.substr(at, end - at);
    at = end;
  }
  return count;
}

/// Lines with their numbers.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    ++number_;
    return true;
  }
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

void add(Points& points, const Eigen::Vector3f& point, const std::string& name) {
  if (points.size() == PointCloud::kMostPoints) {
    fail(name + " must have at most " + std::to_string(PointCloud::kMostPoints) +
         " points; reduce them first, for example to one in each cube of 1 cm");
  }
  points.push_back(point);
}

Points read_xyz(const std::string& bytes, const std::string& name) {
  Points points;
  Lines lines(bytes);
  for (std::string_view line; lines.next(line);) {
    std::array<std::string_view, 3> words;
    const std::size_t count = split(line, words);
    if (count == 0 || words[0].starts_with('#') || words[0].starts_with("//")) continue;
    const std::string where = name + ", line " + std::to_string(lines.number());
    if (count < 3) fail(where + " must have the three numbers x, y and z [m], not " + std::to_string(count));
    Eigen::Vector3f point;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = parse_number(words[i]);
      if (!value || !std::isfinite(*value)) {
        fail(where + ": " + "xyz"[i] + " = " + printable(words[i]) + " must be a finite number [m]");
      }
      point[static_cast<Eigen::Index>(i)] = static_cast<float>(*value);
    }
    add(points, point, name);
  }
  return points;
}

/// The header of a PCD file.
struct PcdHeader {
  std::vector<std::string> fields;
  std::vector<std::size_t> sizes;   ///< [bytes]
  std::vector<char> types;          ///< F, I or U
  std::vector<std::size_t> counts;  ///< of numbers
  std::optional<std::size_t> points;
  std::string data;
};

constexpr std::size_t kMostFields = 64;

std::size_t whole_number(std::string_view word, const std::string& where, std::size_t most) {
  const auto value = parse_number(word);
  if (!value || !(*value >= 0.0 && *value <= static_cast<double>(most)) || std::floor(*value) != *value) {
    fail(where + " = " + printable(word) + " must be a whole number from 0 to " + std::to_string(most));
  }
  return static_cast<std::size_t>(*value);
}

PcdHeader read_header(Lines& lines, const std::string& name) {
  PcdHeader header;
  for (std::string_view line; lines.next(line);) {
    std::array<std::string_view, kMostFields + 1> words;
    const std::size_t count = split(line, words);
    if (count == 0 || words[0].starts_with('#')) continue;
    const std::string where = name + ": " + printable(words[0]);
    const auto values = std::span(words).subspan(1, count - 1);
    for (const std::string_view word : values) {
      if (words[0] == "FIELDS") header.fields.emplace_back(word);
      if (words[0] == "SIZE") header.sizes.push_back(whole_number(word, where, 8));
      if (words[0] == "TYPE") header.types.push_back(word.front());
      if (words[0] == "COUNT") header.counts.push_back(whole_number(word, where, 1'000'000));
      if (words[0] == "POINTS") header.points = whole_number(word, where, 100'000'000);
      if (words[0] == "DATA") header.data = word;
    }
    if (words[0] == "DATA") break;
  }
  if (header.counts.empty()) header.counts.assign(header.fields.size(), 1);
  const std::size_t fields = header.fields.size();
  if (fields == 0 || header.sizes.size() != fields || header.types.size() != fields || header.counts.size() != fields ||
      !header.points || header.data.empty()) {
    fail(name +
         " must be a PCD file: a header with FIELDS, SIZE, TYPE, POINTS and DATA, and as many sizes and types as "
         "fields");
  }
  return header;
}

/// Where a coordinate is in a row of a PCD file.
struct PcdColumn {
  std::size_t word = 0;  ///< in text
  std::size_t byte = 0;  ///< in binary data
  std::size_t size = 4;  ///< [bytes]
};

std::array<PcdColumn, 3> columns_of(const PcdHeader& header, const std::string& name) {
  std::array<PcdColumn, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bool found = false;
    std::size_t word = 0;
    std::size_t byte = 0;
    for (std::size_t i = 0; i < header.fields.size(); ++i) {
      if (header.fields[i] == std::string(1, "xyz"[axis])) {
        found = header.types[i] == 'F' && header.counts[i] == 1 && (header.sizes[i] == 4 || header.sizes[i] == 8);
        columns[axis] = {word, byte, header.sizes[i]};
      }
      word += header.counts[i];
      byte += header.counts[i] * header.sizes[i];
    }
    if (!found) fail(name + " must have the fields x, y and z, each one number of type F and size 4 or 8");
  }
  return columns;
}

/// Adds a point of a PCD file, unless the camera has no measurement there.
void add_measured(Points& points, const std::array<double, 3>& p, const std::string& where, const std::string& name) {
  if (std::any_of(p.begin(), p.end(), [](double x) { return std::isnan(x); })) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::isfinite(static_cast<float>(p[axis]))) continue;
    fail(where + ": " + "xyz"[axis] + " = " + number_text(p[axis]) + " must be a finite number [m]");
  }
  add(points, Eigen::Vector3d(p[0], p[1], p[2]).cast<float>(), name);
}

Points read_pcd_text(const PcdHeader& header, Lines& lines, const std::string& name) {
  const auto columns = columns_of(header, name);
  std::size_t rows = 0;
  Points points;
  for (std::string_view line; rows < *header.points && lines.next(line);) {
    std::array<std::string_view, kMostFields> words;
    const std::size_t count = split(line, words);
    if (count == 0) continue;
    ++rows;
    const std::string where = name + ", line " + std::to_string(lines.number());
    std::array<double, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = columns[axis].word < count ? parse_number(words[columns[axis].word]) : std::nullopt;
      if (!value) fail(where + " must have a number for " + "xyz"[axis]);
      p[axis] = *value;
    }
    add_measured(points, p, where, name);
  }
  if (rows < *header.points) {
    fail(name + " must have " + std::to_string(*header.points) + " points, as its header says, not " +
         std::to_string(rows));
  }
  return points;
}

Points read_pcd_binary(const PcdHeader& header, std::string_view data, const std::string& name) {
  static_assert(std::endian::native == std::endian::little);
  const auto columns = columns_of(header, name);
  std::size_t row = 0;
  for (std::size_t i = 0; i < header.fields.size(); ++i) row += header.sizes[i] * header.counts[i];
  if (data.size() / row < *header.points) {
    fail(name + " must have " + std::to_string(*header.points) + " points of " + std::to_string(row) +
         " bytes, as its header says, but only " + std::to_string(data.size()) + " bytes follow the header");
  }
  Points points;
  for (std::size_t i = 0; i < *header.points; ++i) {
    std::array<double, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const char* const at = data.data() + i * row + columns[axis].byte;
      if (columns[axis].size == 8) {
        std::memcpy(&p[axis], at, sizeof(double));
      } else {
        float value = 0.0F;
        std::memcpy(&value, at, sizeof(float));
        p[axis] = static_cast<double>(value);
      }
    }
    add_measured(points, p, name + ", point " + std::to_string(i + 1), name);
  }
  return points;
}

Points read_pcd(const std::string& bytes, const std::string& name) {
  Lines lines(bytes);
  const PcdHeader header = read_header(lines, name);
  if (header.data == "ascii") return read_pcd_text(header, lines, name);
  if (header.data == "binary") return read_pcd_binary(header, lines.rest(), name);
  fail(name + ": DATA = " + printable(header.data) +
       " must be ascii or binary; 'pcl_convert_pcd_ascii_binary FILE OUT 1' writes binary");
}

}  // namespace

std::vector<Eigen::Vector3f> read_cloud_file(const std::filesystem::path& path, const std::string& name) {
  const std::string type = path.extension().string();
  if (type != ".xyz" && type != ".pcd") fail(name + " must be a file of points: .xyz or .pcd");
  const std::string bytes = bytes_of(path, name);
  Points points = type == ".xyz" ? read_xyz(bytes, name) : read_pcd(bytes, name);
  if (points.empty()) fail(name + " must have at least one point");
  return points;
}

}  // namespace hecaton::config
