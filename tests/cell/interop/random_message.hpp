#pragma once
/// Random messages of ROS 2, of any type of services/ros2_messages.

#include <array>
#include <cmath>
#include <concepts>
#include <string>
#include <vector>

#include "planner/local/random.hpp"

namespace hecaton::test {

/// 0 to `below` − 1.
inline int random_count(planner::Random& random, int below) {
  return static_cast<int>(random.next() % static_cast<std::uint64_t>(below));
}

/// Of magnitudes from 1e-3 to 1e3.
inline double random_number(planner::Random& random) {
  return std::ldexp(random.normal(), random_count(random, 20) - 10);
}

/// Of 0 to 40 letters of one to three bytes.
inline std::string random_text(planner::Random& random) {
  constexpr const char* kLetters[] = {"a", "B", "7", " ", "/", "\"", "\\", "–", "ü", "π", "→"};
  std::string text;
  for (int i = random_count(random, 41); i > 0; --i) text += kLetters[random_count(random, 11)];
  return text;
}

/// Draws each field of a message; sequences have up to four items.
class RandomMessage {
 public:
  explicit RandomMessage(planner::Random& random) : random_(random) {}

  template <class Message>
  [[nodiscard]] Message draw() {
    Message message;
    draw(message);
    return message;
  }
  template <class... T>
  void operator()(T&... values) {
    (draw(values), ...);
  }

 private:
  void draw(bool& value) { value = random_count(random_, 2) == 0; }
  template <std::integral T>
  void draw(T& value) {
    value = static_cast<T>(random_.next());
  }
  void draw(double& value) { value = random_number(random_); }
  void draw(float& value) { value = static_cast<float>(random_number(random_)); }
  void draw(std::string& value) { value = random_text(random_); }
  template <class T>
  void draw(std::vector<T>& items) {
    items.resize(static_cast<std::size_t>(random_count(random_, 5)));
    for (T& item : items) draw(item);
  }
  template <class T, std::size_t N>
  void draw(std::array<T, N>& items) {
    for (T& item : items) draw(item);
  }
  template <class T>
  requires requires(T& value, RandomMessage& visit) { T::fields(value, visit); }
  void draw(T& value) { T::fields(value, *this); }

  planner::Random& random_;
};

}  // namespace hecaton::test
