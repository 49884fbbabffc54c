#pragma once
/// Whether the cell modes of who leads reach anybody on another host: nodes say which they have heard last
/// (Heartbeat.heard_mode). Standard library only: time is an argument.

#include <cstdint>
#include <optional>

#include "services/supervisor/liveness.hpp"

namespace hecaton::services {

/// Which cell mode; both 0: none.
struct HeardMode {
  std::uint64_t term = 0;
  std::uint64_t number = 0;
};

class Echo {
 public:
  /// We lead under this term (> 0), and nobody has heard of it.
  void begin(std::uint64_t term, Time now) {
    term_ = term;
    followed_ = false;
    unanswered_ = Mode{0, now};
  }
  void end() {
    term_ = 0;
    unanswered_.reset();
  }
  /// We have published a cell mode of this number; they grow.
  void said(std::uint64_t number, Time now) {
    if (term_ > 0 && !unanswered_) unanswered_ = Mode{number, now};
  }
  /// Who has heard this mode last has heard the one that has waited for longest.
  [[nodiscard]] bool answers(const HeardMode& mode) const {
    return unanswered_ && mode.term == term_ && mode.number >= unanswered_->number;
  }
  /// A node of another host has.
  void answered() {
    followed_ = true;
    unanswered_.reset();
  }
  /// How long the oldest mode that nobody is known to have heard has waited for that; empty: there is none.
  [[nodiscard]] std::optional<Time> unanswered_for(Time now) const {
    return unanswered_ ? std::optional(now - unanswered_->at) : std::nullopt;
  }
  /// Some mode of this term was heard.
  [[nodiscard]] bool followed() const { return followed_; }

 private:
  struct Mode {
    std::uint64_t number = 0;
    Time at{0};
  };
  std::uint64_t term_ = 0;  // 0: we do not lead
  std::optional<Mode> unanswered_;
  bool followed_ = false;
};

}  // namespace hecaton::services
