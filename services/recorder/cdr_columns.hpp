#pragma once
/// The fields of a message as columns of text. The table of the wire's rules describes the message, so that no
/// generated code is needed.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/wire_rules.hpp"
#include "services/recorder/mcap_format.hpp"

namespace hecaton::services::recorder {

/// Columns of one type of messages. A field of a structure becomes the column "cause.kind". A sequence of at most
/// kMostElements numbers becomes the columns "q[0]", "q[1]" and so on, as many as the longest message needs. Any other
/// sequence becomes one column with a JSON list. For one thread.
class CdrColumns {
 public:
  static constexpr std::uint32_t kMostElements = 64;

  /// `rule` must outlive the object.
  explicit CdrColumns(const bus::TopicRule& rule) : rule_(rule) {}

  /// Makes room for the sequences of a message, which includes its encapsulation. Returns why the message breaks its
  /// rule; then it has no row.
  [[nodiscard]] std::optional<std::string> measure(ByteSpan message);
  /// Names of the columns, for the messages that were measured.
  [[nodiscard]] std::vector<std::string> header() const;
  /// The values of a message that was measured, one for each column: numbers in the shortest form that reads back the
  /// same, enumerators as numbers, booleans as 0 or 1. Empty for elements that a sequence does not have.
  [[nodiscard]] std::vector<std::string> row(ByteSpan message) const;

 private:
  const bus::TopicRule& rule_;
  std::map<std::string, std::size_t> lengths_;  ///< of sequences with columns of their own: the longest, by path
};

/// A line of a CSV file (RFC 4180), with its end.
[[nodiscard]] std::string csv_line(const std::vector<std::string>& cells);

}  // namespace hecaton::services::recorder
