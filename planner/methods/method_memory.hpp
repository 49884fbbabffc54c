#pragma once
/// The memory of a motion method between ticks: a value of the method's own type, stored in place.

#include <cstddef>
#include <memory>
#include <new>

#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// Holds one value of any copyable type of at most `kCapacity` bytes, or nothing. Copies copy the value without
/// allocation, so that a rollout can copy the memory of a planner. Not thread-safe.
class MethodMemory {
 public:
  static constexpr std::size_t kCapacity = 1024;  ///< [bytes]

  MethodMemory() = default;
  MethodMemory(const MethodMemory& other) { take(other); }  ///< copies the value
  /// Destroys its value and copies the other.
  MethodMemory& operator=(const MethodMemory& other) {
    if (this != &other) {
      clear();
      take(other);
    }
    return *this;
  }
  ~MethodMemory() { clear(); }

  /// Destroys the value; then the memory is empty.
  void clear() {
    if (type_ != nullptr) type_->destroy(bytes_);
    type_ = nullptr;
  }

  /// The value. Stores a T{} first if the memory is empty or holds another type.
  template <class T>
  [[nodiscard]] T& as() {
    static_assert(sizeof(T) <= kCapacity && alignof(T) <= kAlignment, "T does not fit into a method's memory");
    if (type_ != &kType<T>) {
      clear();
      ::new (static_cast<void*>(bytes_)) T{};
      type_ = &kType<T>;
    }
    return *std::launder(reinterpret_cast<T*>(bytes_));
  }

  /// Saves or loads the value. `prepare` stores a default value of the type that is loaded. A type without describe()
  /// cannot be saved: then the archive fails.
  template <class Prepare>
  void describe(MemoryArchive& archive, const Prepare& prepare) {
    bool has = type_ != nullptr;
    archive(has);
    if (archive.loads()) {
      clear();
      if (has) prepare();
      if (has && type_ == nullptr) archive.fail();
    }
    if (type_ != nullptr) type_->describe(bytes_, archive);
  }

 private:
  static constexpr std::size_t kAlignment = 32;

  struct Type {
    void (*copy)(const std::byte* from, std::byte* to);
    void (*destroy)(std::byte* value);
    void (*describe)(std::byte* value, MemoryArchive& archive);
  };
  template <class T>
  static constexpr Type kType{[](const std::byte* from, std::byte* to) {
                                ::new (static_cast<void*>(to)) T(*std::launder(reinterpret_cast<const T*>(from)));
                              },
                              [](std::byte* value) { std::destroy_at(std::launder(reinterpret_cast<T*>(value))); },
                              [](std::byte* value, MemoryArchive& archive) {
                                if constexpr (requires(T & one) { one.describe(archive); }) {
                                  std::launder(reinterpret_cast<T*>(value))->describe(archive);
                                } else {
                                  archive.fail();
                                }
                              }};

  void take(const MethodMemory& other) {
    if (other.type_ != nullptr) other.type_->copy(other.bytes_, bytes_);
    type_ = other.type_;
  }

  const Type* type_ = nullptr;
  alignas(kAlignment) std::byte bytes_[kCapacity];
};

}  // namespace hecaton::planner
