#pragma once
/// A file of a fixed size, mapped into memory: what is written there is there for a successor however suddenly the
/// process ends, and writing costs a copy. It is not meant to survive the machine.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

namespace hecaton::services {

class MappedFile {
 public:
  /// Of `size` bytes, zero where there was nothing. All of it is reserved now: on a full disk, whoever wrote to a page
  /// that has no place yet would be killed. An empty path: there is none. Throws std::runtime_error with a sentence
  /// that begins with the path when the file cannot be used; `what` was to be kept in it.
  MappedFile(const std::string& path, std::size_t size, const std::string& what);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] void* data() const { return data_; }  ///< null: there is none

 private:
  void* data_ = nullptr;
  std::size_t size_;
};

/// One value in a mapped file. Two slots are written in turns, so that one of them is whole whenever the process ends.
template <class Value>
requires std::is_trivially_copyable_v<Value>
class MappedRecord {
 public:
  /// `layout` tells apart what other editions and other arms have written. See MappedFile for the rest.
  MappedRecord(const std::string& path, std::uint64_t layout, const std::string& what)
      : layout_(sizeof(Value) << 16U | layout),
        file_(path, 2 * sizeof(Slot), what),
        slots_(static_cast<Slot*>(file_.data())) {
    if (const Slot* last = newest()) number_ = last->number;
  }

  /// What was remembered last; nothing when there is no file, or none of this layout.
  [[nodiscard]] std::optional<Value> recall() const {
    const Slot* slot = newest();
    return slot == nullptr ? std::nullopt : std::optional<Value>(slot->value);
  }
  void remember(const Value& value) {
    if (slots_ == nullptr) return;
    Slot& slot = slots_[++number_ % 2];
    const std::atomic_ref<std::uint64_t> number(slot.number);
    number.store(0, std::memory_order_seq_cst);  // a reader now takes the other slot
    slot.layout = layout_;
    slot.value = value;
    number.store(number_, std::memory_order_release);
  }

 private:
  struct Slot {
    std::uint64_t number;  ///< counts what is remembered, from 1; 0: nothing, or half written
    std::uint64_t layout;
    Value value;
  };

  [[nodiscard]] const Slot* newest() const {
    const Slot* last = nullptr;
    for (const Slot* slot = slots_; slot != nullptr && slot != slots_ + 2; ++slot) {
      const bool whole = slot->number > 0 && slot->layout == layout_;
      if (whole && (last == nullptr || slot->number > last->number)) last = slot;
    }
    return last;
  }

  std::uint64_t layout_;
  MappedFile file_;
  Slot* slots_;
  std::uint64_t number_ = 0;
};

}  // namespace hecaton::services
