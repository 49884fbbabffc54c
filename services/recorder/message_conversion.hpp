#pragma once
/// Brings a message from one version of its structure into another, field by field and by their names.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "services/recorder/idl_types.hpp"
#include "services/recorder/mcap_format.hpp"

namespace hecaton::services::recorder {

/// A structure or a message that cannot be converted. what() is a phrase that begins with the field.
class ConversionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A field that only the new structure has gets its default, one that only the old one has is left out, an enumerator
/// is found by its label, and a number may become one of a wider type. The first field `schema` gets its default: it
/// is the version itself. For one thread.
class MessageConversion {
 public:
  /// Both must outlive the object. `most_bytes`: no converted message is longer. Throws ConversionError when a field
  /// has types that cannot be converted.
  MessageConversion(const IdlType& from, const IdlType& to, std::size_t most_bytes);

  /// Plain CDR with its encapsulation, both. The result is valid until the next call. Throws ConversionError.
  [[nodiscard]] ByteSpan convert(ByteSpan message);

  /// Both structures are the same, with the same fields in the same order.
  [[nodiscard]] bool is_same() const { return same_; }
  /// Fields that the old structures lack, and fields that were left out: "TickArm.speed". In the order of the text.
  [[nodiscard]] const std::vector<std::string>& added() const { return added_; }
  [[nodiscard]] const std::vector<std::string>& removed() const { return removed_; }

 private:
  class Writer;
  class Run;
  struct Structure;
  /// How a value becomes another.
  struct Step {
    const IdlType* from = nullptr;
    const IdlType* to = nullptr;
    const Step* element = nullptr;         ///< of a sequence or an array
    const Structure* structure = nullptr;  ///< of a structure
    /// Of an enumeration, by the old number; empty: the new one lacks the label.
    std::map<std::uint32_t, std::optional<std::uint32_t>> numbers{};
  };
  struct Structure {
    const IdlType* from = nullptr;
    const IdlType* to = nullptr;
    std::vector<const Step*> steps;                   ///< by old field; null: it is left out
    std::vector<std::optional<std::size_t>> sources;  ///< by new field: the old one; empty: it gets its default
    bool in_order = true;                             ///< the sources only grow
  };

  const Step* step(const IdlType& from, const IdlType& to);
  const Structure* structure(const IdlType& from, const IdlType& to, bool outermost);
  void differ() { same_ = false; }

  std::deque<Step> steps_;
  std::deque<Structure> structures_;
  std::map<std::pair<const IdlType*, const IdlType*>, const Step*> known_;
  const Structure* root_ = nullptr;
  std::size_t most_bytes_;
  bool same_ = true;
  std::vector<std::string> added_;
  std::vector<std::string> removed_;
  Bytes converted_;
};

}  // namespace hecaton::services::recorder
