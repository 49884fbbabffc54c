#pragma once
/// A DDS domain that no other test on this machine uses at the same time.

namespace hecaton::test {

class FreeDomain {
 public:
  /// Throws std::runtime_error if all domains from 44 to 100 are in use.
  FreeDomain();
  ~FreeDomain();
  FreeDomain(const FreeDomain&) = delete;
  FreeDomain& operator=(const FreeDomain&) = delete;

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_ = -1;
  int lock_ = -1;
};

}  // namespace hecaton::test
