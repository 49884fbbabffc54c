#pragma once
/// Files whose contents are whole however the process ends: those before the last write or those after it. Standard
/// library and system calls only.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

namespace hecaton::services {

/// Replaces the contents of the file at `path`. Two files take turns, `path` and spare_file_of(path), and their room on
/// the disk is reserved beforehand: a disk that fills up later does no harm until the contents outgrow it. `padding`
/// fills the reserved room behind the contents. Returns nothing, or a sentence that begins with the path and says why
/// the contents cannot be written; the former contents then stay.
[[nodiscard]] std::optional<std::string> write_atomically(const std::string& path, std::string contents, char padding);

/// Where the other of the two files is.
[[nodiscard]] std::string spare_file_of(const std::string& path);

/// A file of fixed size mapped into memory: a write costs a copy, and a successor of a killed process finds it. The
/// contents need not survive the machine.
class MappedFile {
 public:
  /// Maps `size` bytes, zero where the file is new. It reserves all of them now, because a write to a page without room
  /// on a full disk kills the process. An empty path maps nothing. Throws std::runtime_error with a sentence that
  /// begins with the path when the file cannot be used; `what` names the contents in it.
  MappedFile(const std::string& path, std::size_t size, const std::string& what);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] void* data() const { return data_; }  ///< null: nothing is mapped

 private:
  void* data_ = nullptr;
  std::size_t size_;
};

/// One value in a mapped file. Two slots are written in turns, so that one of them is whole whenever the process ends.
template <class Value>
requires std::is_trivially_copyable_v<Value>
class MappedRecord {
 public:
  /// `layout` distinguishes values of other program versions and other arms. See MappedFile for the rest.
  MappedRecord(const std::string& path, std::uint64_t layout, const std::string& what)
      : layout_(sizeof(Value) << 16U | layout),
        file_(path, 2 * sizeof(Slot), what),
        slots_(static_cast<Slot*>(file_.data())) {
    if (const Slot* last = newest()) number_ = last->number;
  }

  /// The value stored last; empty when there is no file, or no value of this layout.
  [[nodiscard]] std::optional<Value> recall() const {
    const Slot* slot = newest();
    return slot == nullptr ? std::nullopt : std::optional<Value>(slot->value);
  }
  /// Does nothing without a file.
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
    std::uint64_t number;  ///< counts the stored values from 1; 0: none, or half written
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
