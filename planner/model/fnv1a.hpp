#pragma once
/// The FNV-1a hash (64 bit): equal in every process and on every machine. Not cryptographic.

#include <cstdint>
#include <string_view>

namespace hecaton::planner {

class Fnv1a {
 public:
  /// One byte; a larger value counts as one symbol.
  constexpr void add(std::uint64_t symbol) { hash_ = (hash_ ^ symbol) * 0x100000001b3U; }
  constexpr void add(std::string_view bytes) {
    for (const char byte : bytes) add(std::uint64_t{static_cast<unsigned char>(byte)});
  }
  [[nodiscard]] constexpr std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

[[nodiscard]] constexpr std::uint64_t fnv1a(std::string_view bytes) {
  Fnv1a hash;
  hash.add(bytes);
  return hash.value();
}

}  // namespace hecaton::planner
