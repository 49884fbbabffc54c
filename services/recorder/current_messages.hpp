#pragma once
/// The messages of a recording in the version of this program. A recording brings the structures of its messages with
/// it, so that those of another version can be converted.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "services/recorder/idl_types.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/message_conversion.hpp"

namespace hecaton::services::recorder {

/// A message that this program can decode, or why there is none.
struct CurrentMessage {
  ByteSpan data;        ///< plain CDR; valid until the next call, and no longer than the recorded message
  std::string refusal;  ///< a sentence that names the topic and the field; empty: none
  /// Why a planner of this program may work otherwise with the message: "version 12 lacks TickArm.speed". Empty: it has
  /// all fields, and no others. Valid as long as the CurrentMessages.
  std::string_view lack;
};

/// For one thread.
class CurrentMessages {
 public:
  /// Topics of Hecaton whose structures are read at most.
  static constexpr std::size_t kMostTexts = 64;

  /// Messages that are none of Hecaton's come back as they are.
  [[nodiscard]] CurrentMessage of(const McapMessage& message);

  /// What a reader must know of the messages so far, a sentence each. Empty: they are of this program's version.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  /// The structures of one type of messages in a recording, and how they become those of this program.
  struct Track {
    std::optional<std::uint32_t> version;  ///< that the text states; empty: it cannot be read
    std::string refusal;                   ///< a phrase; empty: messages can be converted
    std::unique_ptr<const IdlTypes> from;
    std::unique_ptr<const IdlTypes> to;
    std::unique_ptr<MessageConversion> conversion;  ///< null: messages stay as they are
    std::string lack;
    bool noted = false;  ///< its fields are in the notes
  };

  [[nodiscard]] Track* track_of(const std::shared_ptr<const McapChannel>& channel);
  [[nodiscard]] static Track make_track(std::string_view type, std::string_view text);
  void note(Track& track);

  std::unordered_map<std::shared_ptr<const McapChannel>, Track*> channels_;  ///< null: messages stay as they are
  std::map<std::pair<std::string, std::string>, Track> tracks_;              ///< by type and text
  std::set<std::uint32_t> versions_;                                         ///< that were converted
  std::set<std::string> added_;                                              ///< fields that they lack
  std::set<std::string> removed_;                                            ///< fields that were left out
};

}  // namespace hecaton::services::recorder
