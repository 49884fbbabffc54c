#include "planner/collision/filter_cache.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "planner/model/fnv1a.hpp"

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kForm = "hecaton link pairs 1\n";
constexpr std::size_t kMostFiles = 256;
constexpr std::size_t kMostBytes = std::size_t{64} << 20U;  // of a file

/// Numbers and texts, one after the other.
class FilterBytes {
 public:
  void add(std::uint64_t value) {
    for (int shift = 0; shift < 64; shift += 8) bytes_ += static_cast<char>(value >> static_cast<unsigned>(shift));
  }
  void add_number(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add_index(int value) { add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value))); }
  void add_text(std::string_view text) {
    add(text.size());
    bytes_ += text;
  }
  void add_vector(const auto& vector) {
    add(static_cast<std::uint64_t>(vector.size()));
    for (const double value : vector) add_number(value);
  }
  void add_pose(const Pose& pose) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 4; ++k) add_number(pose.matrix()(i, k));
    }
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what FilterBytes wrote. Bytes that end too early read as zeros and are not good.
class FilterBytesReader {
 public:
  explicit FilterBytesReader(std::string_view bytes) : rest_(bytes) {}

  std::uint64_t number() {
    if (rest_.size() < 8) return fail();
    std::uint64_t value = 0;
    for (std::size_t i = 8; i-- > 0;) value = value << 8U | static_cast<unsigned char>(rest_[i]);
    rest_.remove_prefix(8);
    return value;
  }
  double real() { return std::bit_cast<double>(number()); }
  int index() { return static_cast<int>(static_cast<std::int64_t>(number())); }
  /// Of elements that have at least 8 bytes each.
  std::size_t size() {
    const std::uint64_t count = number();
    return count > rest_.size() / 8 ? fail() : count;
  }
  std::string_view text() {
    const std::uint64_t length = number();
    if (length > rest_.size()) {
      fail();
      return {};
    }
    const std::string_view text = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return text;
  }
  JointVector joints() {
    const std::size_t count = size();
    JointVector q = JointVector::Zero(count <= static_cast<std::size_t>(kMaxJoints) ? static_cast<int>(count) : 0);
    for (double& value : q) value = real();
    return q;
  }
  [[nodiscard]] bool complete() const { return good_ && rest_.empty(); }

 private:
  std::uint64_t fail() {
    good_ = false;
    rest_ = {};
    return 0;
  }

  std::string_view rest_;
  bool good_ = true;
};

/// False: a cloud of points.
bool add_shape(FilterBytes& bytes, const world::Shape& shape) {
  bytes.add(shape.index());
  struct Visitor {
    FilterBytes& bytes;
    bool operator()(const world::Box& box) const {
      bytes.add_vector(box.half_extents);
      return true;
    }
    bool operator()(const world::Sphere& sphere) const {
      bytes.add_number(sphere.radius);
      return true;
    }
    bool operator()(const world::Capsule& capsule) const {
      bytes.add_number(capsule.radius);
      bytes.add_number(capsule.half_length);
      return true;
    }
    bool operator()(const world::Cylinder& cylinder) const {
      bytes.add_number(cylinder.radius);
      bytes.add_number(cylinder.half_length);
      return true;
    }
    bool operator()(const world::Convex& convex) const {
      bytes.add(convex.hull->vertices.size());
      for (const Eigen::Vector3d& vertex : convex.hull->vertices) bytes.add_vector(vertex);
      bytes.add(convex.hull->faces.size());
      for (const std::vector<int>& face : convex.hull->faces) {
        bytes.add(face.size());
        for (const int vertex : face) bytes.add_index(vertex);
      }
      return true;
    }
    bool operator()(const world::Points&) const { return false; }
  };
  return std::visit(Visitor{bytes}, shape);
}

void add_link(FilterBytes& bytes, const Link& link) {
  // Names every member: the compiler then asks for a new one here.
  const auto& [name, parent, joint_type, joint_name, X_PJ, axis, joint, follows, multiplier, offset, motion] = link;
  bytes.add_text(name);
  bytes.add_index(parent);
  bytes.add(static_cast<std::uint64_t>(joint_type));
  bytes.add_text(joint_name);
  bytes.add_pose(X_PJ);
  bytes.add_vector(axis);
  bytes.add_index(joint);
  bytes.add(follows ? 1 : 0);
  bytes.add_number(multiplier);
  bytes.add_number(offset);
  bytes.add(static_cast<std::uint64_t>(motion));
}

void add_options(FilterBytes& bytes, const FilterOptions& options) {
  const auto& [samples, random_seed, always, contact, apart, proof_budget, close, adjacent, touching, close_budget] =
      options;
  bytes.add_index(samples);
  bytes.add(random_seed);
  for (const double value : {always, contact, apart, close, adjacent, touching}) bytes.add_number(value);
  bytes.add_index(proof_budget);
  bytes.add_index(close_budget);
}

void add_pairs(FilterBytes& bytes, const RobotModel& model) {
  bytes.add(model.self_pairs.size());
  for (const auto& [a, b] : model.self_pairs) {
    bytes.add_index(a);
    bytes.add_index(b);
  }
}

/// What automatic_filter() changed.
std::string result_bytes(const RobotModel& before, const RobotModel& after) {
  FilterBytes bytes;
  add_pairs(bytes, after);
  bytes.add(after.close_pairs.size());
  for (const ClosePair& pair : after.close_pairs) {
    bytes.add_index(pair.first);
    bytes.add_index(pair.second);
    bytes.add_number(pair.widest);
  }
  bytes.add_vector(after.limits.lower);
  bytes.add_vector(after.limits.upper);
  for (const Link& link : after.links) bytes.add(static_cast<std::uint64_t>(link.joint_type));
  const auto add_new = [&bytes](const std::vector<std::string>& old, const std::vector<std::string>& all) {
    bytes.add(all.size() - old.size());
    for (std::size_t i = old.size(); i < all.size(); ++i) bytes.add_text(all[i]);
  };
  add_new(before.notes, after.notes);
  add_new(before.details, after.details);
  bytes.add(after.named.size());
  for (const auto& [name, q] : after.named) bytes.add_text(name);
  return bytes.take();
}

bool has_pair(const RobotModel& model, const std::pair<int, int>& pair) {
  return std::find(model.self_pairs.begin(), model.self_pairs.end(), pair) != model.self_pairs.end();
}

bool are_narrower(const JointLimits& limits, const JointLimits& before) {
  return limits.lower.size() == before.lower.size() && limits.upper.size() == before.upper.size() &&
         (limits.lower.array() >= before.lower.array()).all() && (limits.upper.array() <= before.upper.array()).all() &&
         (limits.lower.array() < limits.upper.array()).all();
}

/// Applies result_bytes(). Empty when the bytes change the model in a way in which automatic_filter() never does.
std::optional<RobotModel> applied(std::string_view result, const RobotModel& before) {
  FilterBytesReader reader(result);
  RobotModel model = before;
  model.self_pairs.clear();
  const std::size_t pairs = reader.size();
  for (std::size_t i = 0; i < pairs; ++i) {
    const int first = reader.index();
    const std::pair<int, int> pair{first, reader.index()};
    if (!has_pair(before, pair)) return std::nullopt;
    model.self_pairs.push_back(pair);
  }
  const std::size_t close_pairs = reader.size();
  for (std::size_t i = 0; i < close_pairs; ++i) {
    ClosePair pair;
    pair.first = reader.index();
    pair.second = reader.index();
    pair.widest = reader.real();
    if (!has_pair(model, {pair.first, pair.second}) || !(pair.widest > 0.0)) return std::nullopt;
    model.close_pairs.push_back(pair);
  }
  model.limits.lower = reader.joints();
  model.limits.upper = reader.joints();
  if (!are_narrower(model.limits, before.limits)) return std::nullopt;
  for (Link& link : model.links) {
    const std::uint64_t type = reader.number();
    if (type == static_cast<std::uint64_t>(link.joint_type)) continue;
    if (link.joint_type != JointType::kContinuous || type != static_cast<std::uint64_t>(JointType::kRevolute)) {
      return std::nullopt;
    }
    link.joint_type = JointType::kRevolute;
  }
  for (std::vector<std::string>* list : {&model.notes, &model.details}) {
    const std::size_t added = reader.size();
    for (std::size_t i = 0; i < added; ++i) list->emplace_back(reader.text());
  }
  model.named.clear();
  const std::size_t poses = reader.size();
  for (std::size_t i = 0; i < poses; ++i) {
    const auto pose = before.named.find(std::string(reader.text()));
    if (pose == before.named.end()) return std::nullopt;
    model.named.insert(*pose);
  }
  if (!reader.complete()) return std::nullopt;
  return model;
}

/// The bytes of a regular file that this user alone can have written; empty: there is none.
std::string read_own_file(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return {};
  std::string bytes;
  struct stat status {};
  const bool own = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
                   (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
  if (own && status.st_size > 0 && static_cast<std::size_t>(status.st_size) <= kMostBytes) {
    bytes.resize(static_cast<std::size_t>(status.st_size));
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t count = ::read(file, bytes.data() + done, bytes.size() - done);
      if (count <= 0) break;
      done += static_cast<std::size_t>(count);
    }
    bytes.resize(done);
  }
  ::close(file);
  return bytes;
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

void remove_oldest(const fs::path& folder) {
  std::error_code error;
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    files.emplace_back(entry.last_write_time(error), entry.path());
  }
  if (files.size() <= kMostFiles) return;
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i + kMostFiles < files.size(); ++i) fs::remove(files[i].second, error);
}

std::string body_of(std::string_view inputs, std::string_view result) {
  FilterBytes bytes;
  bytes.add_text(inputs);
  bytes.add_text(result);
  return bytes.take();
}

fs::path& chosen_folder() {
  static fs::path folder;
  return folder;
}

}  // namespace

void keep_filter_results_in(fs::path folder) {
  chosen_folder() = std::move(folder);
}

const fs::path& folder_of_filter_results() {
  return chosen_folder();
}

std::string filter_inputs(const RobotModel& model, const FilterOptions& options) {
  FilterBytes bytes;
  bytes.add_text(filter_code());
  add_options(bytes, options);
  bytes.add(model.links.size());
  for (const Link& link : model.links) add_link(bytes, link);
  bytes.add(model.geometry.size());
  for (const LinkGeometry& geometry : model.geometry) {
    bytes.add_index(geometry.link);
    bytes.add_pose(geometry.X_LS);
    if (!add_shape(bytes, geometry.shape)) return {};
  }
  bytes.add(model.joint_names.size());
  for (const std::string& name : model.joint_names) bytes.add_text(name);
  bytes.add(model.beside.size());
  for (const auto& [name, type] : model.beside) {
    bytes.add_text(name);
    bytes.add(static_cast<std::uint64_t>(type));
  }
  bytes.add(model.has_followers ? 1 : 0);
  bytes.add_vector(model.limits.lower);
  bytes.add_vector(model.limits.upper);
  add_pairs(bytes, model);
  bytes.add(model.named.size());
  for (const auto& [name, q] : model.named) {
    bytes.add_text(name);
    bytes.add_vector(q);
  }
  return bytes.take();
}

fs::path file_of_filter(const fs::path& folder, std::string_view inputs) {
  std::array<char, 17> name{};
  std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(fnv1a(inputs)));
  return folder / name.data();
}

std::optional<RobotModel> kept_filter_result(const fs::path& folder, std::string_view inputs,
                                             const RobotModel& before) {
  const std::string bytes = read_own_file(file_of_filter(folder, inputs));
  std::string_view rest = bytes;
  if (!rest.starts_with(kForm)) return std::nullopt;
  rest.remove_prefix(kForm.size());
  if (rest.size() < 8) return std::nullopt;
  const std::uint64_t checksum = FilterBytesReader(rest.substr(0, 8)).number();
  rest.remove_prefix(8);
  if (checksum != fnv1a(rest)) return std::nullopt;
  FilterBytesReader reader(rest);
  if (reader.text() != inputs) return std::nullopt;
  const std::string_view result = reader.text();
  return reader.complete() ? applied(result, before) : std::nullopt;
}

void keep_filter_result(const fs::path& folder, std::string_view inputs, const RobotModel& before,
                        const RobotModel& after) {
  std::error_code error;
  fs::create_directories(folder, error);
  const std::string body = body_of(inputs, result_bytes(before, after));
  if (body.size() > kMostBytes / 2) return;
  FilterBytes head;
  head.add(fnv1a(body));
  // mkstemp() makes a file that this user alone can read and write.
  std::string temporary = (folder / "new-XXXXXX").string();
  const int file = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (file < 0) return;
  const bool written = write_all(file, kForm) && write_all(file, head.take()) && write_all(file, body);
  if (::close(file) != 0 || !written) {
    fs::remove(temporary, error);
    return;
  }
  fs::rename(temporary, file_of_filter(folder, inputs), error);
  if (error) fs::remove(temporary, error);
  remove_oldest(folder);
}

}  // namespace hecaton::planner
