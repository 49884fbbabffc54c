#pragma once
/// Messages as the bytes of the wire. It includes Fast DDS: for one source of a test.

#include <cstdint>
#include <string>
#include <vector>

#include "services/bus/type_support.hpp"

namespace hecaton::test {

/// CDR with its encapsulation.
template <class T>
std::vector<std::uint8_t> cdr_of(const T& message) {
  const std::string bytes = bus::GuardedType<T>().bytes_of(message);
  return {bytes.begin(), bytes.end()};
}

}  // namespace hecaton::test
