#pragma once
/// Saves the memory of a planner as words, and loads it again, bit by bit. A recording holds such words, so that the
/// planner can be recomputed from there.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// Each class with a memory has a function describe(MemoryArchive&), which passes all its values in one order. It
/// serves both directions. Words mean the same in one version of the program only. Not thread-safe.
class MemoryArchive {
 public:
  /// Saves.
  MemoryArchive() = default;
  /// Loads `words`, which must outlive the archive. `arms`, `joints`: of the cell, and of the own arm. They bound
  /// indices and sizes, since words come from files.
  MemoryArchive(std::span<const std::uint32_t> words, int arms, int joints)
      : loads_(true), rest_(words), arms_(arms), joints_(joints) {}

  [[nodiscard]] bool loads() const { return loads_; }
  /// False: the words are not those of this planner, or a part of the memory cannot be saved.
  [[nodiscard]] bool good() const { return good_; }
  /// All words were loaded.
  [[nodiscard]] bool complete() const { return good_ && rest_.empty(); }
  void fail() { good_ = false; }

  /// As saved.
  [[nodiscard]] std::vector<std::uint32_t> take_words() { return std::move(words_); }

  template <class T>
  void operator()(T& value) {
    if constexpr (requires { value.describe(*this); }) {
      value.describe(*this);
    } else if constexpr (std::is_same_v<T, bool>) {
      number(value, 0, 1);
    } else if constexpr (std::is_same_v<T, std::uint32_t>) {
      word(value);
    } else if constexpr (std::is_same_v<T, std::uint64_t> || std::is_same_v<T, double>) {
      long_word(value);
    } else {
      static_assert(std::is_same_v<T, JointVector>, "describe the type, or use number()");
      joints(value, joints_);
    }
  }
  /// One after the other.
  template <class First, class Second, class... Rest>
  void operator()(First& first, Second& second, Rest&... rest) {
    (*this)(first);
    (*this)(second, rest...);
  }

  /// An integer or an enumeration within [low, high].
  template <class T>
  void number(T& value, std::int64_t low, std::int64_t high) {
    auto word_of = static_cast<std::uint32_t>(value);
    word(word_of);
    if (!loads_) return;
    const std::int64_t loaded = static_cast<std::int32_t>(word_of);
    if (loaded < low || loaded > high) return fail();
    value = static_cast<T>(loaded);
  }
  /// The index of an arm, or −1.
  void arm(int& value) { number(value, -1, arms_ - 1); }
  /// The index of an arm.
  void index(int& value) { number(value, 0, arms_ - 1); }
  /// A count or an index that nothing else bounds.
  void count(int& value) { number(value, -1, std::numeric_limits<std::int32_t>::max()); }

  /// Coordinates of a vector of fixed size.
  template <class Vector>
  void coordinates(Vector& vector) {
    for (auto& value : vector) (*this)(value);
  }
  /// Joints of any arm.
  void any_joints(JointVector& q) { joints(q, 0); }

  /// `element` describes one element.
  template <class T, class Describe>
  void list(std::vector<T>& values, Describe&& element) {
    constexpr std::uint32_t kMost = 1U << 16U;
    auto size = static_cast<std::uint32_t>(values.size());
    word(size);
    if (loads_) {
      if (size > kMost || size > rest_.size()) return fail();
      values.assign(size, T());
    }
    for (T& value : values) element(value);
  }
  template <class T, class Describe>
  void optional(std::optional<T>& value, Describe&& describe) {
    bool has = value.has_value();
    (*this)(has);
    if (loads_) value = has ? std::optional<T>(T()) : std::nullopt;
    if (value) describe(*value);
  }
  template <class T>
  void optional(std::optional<T>& value) {
    optional(value, [this](T& held) { (*this)(held); });
  }

 private:
  void word(std::uint32_t& value) {
    if (!loads_) return words_.push_back(value);
    if (rest_.empty()) {
      value = 0;
      return fail();
    }
    value = rest_.front();
    rest_ = rest_.subspan(1);
  }
  template <class T>
  void long_word(T& value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    auto low = static_cast<std::uint32_t>(bits);
    auto high = static_cast<std::uint32_t>(bits >> 32U);
    word(low);
    word(high);
    if (loads_) value = std::bit_cast<T>(static_cast<std::uint64_t>(high) << 32U | low);
  }
  /// `expected` 0: any size.
  void joints(JointVector& q, int expected) {
    auto size = static_cast<std::uint32_t>(q.size());
    word(size);
    if (loads_) {
      const bool fits = size == 0 || expected == 0 || static_cast<int>(size) == expected;
      if (size > static_cast<std::uint32_t>(kMaxJoints) || !fits) {
        q.resize(0);
        return fail();
      }
      q.resize(static_cast<Eigen::Index>(size));
    }
    for (double& value : q) long_word(value);
  }

  bool loads_ = false;
  bool good_ = true;
  std::vector<std::uint32_t> words_;
  std::span<const std::uint32_t> rest_;
  int arms_ = 0;
  int joints_ = 0;
};

}  // namespace hecaton::planner
