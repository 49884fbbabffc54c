#include "services/runtime/cell_mode.hpp"

#include <algorithm>

#include "services/bus/endpoint.hpp"

namespace hecaton::services {
namespace {

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whatever faults hold beside.
ArmOrder ordered_by_people(const msg::CellMode& mode, std::string_view arm) {
  if (mode.ordered() == msg::Mode::MODE_STOP || contains(mode.stopped_arms(), arm)) return ArmOrder::kStop;
  if (mode.ordered() == msg::Mode::MODE_HOLD || contains(mode.arms_ordered_to_hold(), arm)) return ArmOrder::kHold;
  return ArmOrder::kRun;
}

/// Of all that `former` orders, as strictly.
bool knows_orders_of(const msg::CellMode& former, const msg::CellMode& mode) {
  const auto holds = [&](const std::string& arm) {
    return contains(mode.arms_ordered_to_hold(), arm) || contains(mode.stopped_arms(), arm);
  };
  const auto stops = [&](const std::string& arm) { return contains(mode.stopped_arms(), arm); };
  return mode.ordered() >= former.ordered() && std::ranges::all_of(former.stopped_arms(), stops) &&
         std::ranges::all_of(former.arms_ordered_to_hold(), holds);
}

ArmOrder order_in(const msg::CellMode& mode, std::string_view arm) {
  if (mode.mode() == msg::Mode::MODE_STOP || contains(mode.stopped_arms(), arm)) return ArmOrder::kStop;
  if (mode.mode() == msg::Mode::MODE_HOLD || contains(mode.held_arms(), arm)) return ArmOrder::kHold;
  return ArmOrder::kRun;
}

}  // namespace

msg::ModeNumber number_of(const msg::CellMode& mode) {
  msg::ModeNumber number;
  number.term(mode.term());
  number.sequence_number(mode.sequence_number());
  return number;
}

// Within a term the latest arrival counts, not the highest sequence number: a supervisor that restarted within its term
// counts from one again.
bool CellModeView::apply(const msg::CellMode& mode, bus::Clock::time_point received) {
  if (mode.term() < term_) return false;
  if (mode.term() > term_ && !former_) {
    if (!knows_orders_of(mode_, mode)) former_ = mode_;
    changed_ = received;
  }
  if (former_ && (received - changed_ >= kDoubt || knows_orders_of(*former_, mode))) former_.reset();
  heard_ = true;
  term_ = mode.term();
  mode_ = mode;
  received_ = received;
  return true;
}

Mandate CellModeView::mandate(std::string_view arm) const {
  for (const msg::Grant& grant : mode_.grants()) {
    if (grant.arm() == arm) return {grant.planner(), grant.term()};
  }
  return {{}, term_};
}

const msg::LostArm* CellModeView::lost(std::string_view arm) const {
  if (!heard_) return nullptr;
  const auto& lost = mode_.lost_arms();
  const auto found = std::find_if(lost.begin(), lost.end(), [&](const msg::LostArm& one) { return one.arm() == arm; });
  return found == lost.end() ? nullptr : &*found;
}

ArmOrder CellModeView::order(std::string_view arm) const {
  if (!heard_) return ArmOrder::kUnheard;
  const ArmOrder now = order_in(mode_, arm);
  return former_ ? std::max(now, ordered_by_people(*former_, arm)) : now;
}

std::string CellModeView::why(std::string_view arm) const {
  const ArmOrder what = order(arm);
  if (heard_ && what != order_in(mode_, arm)) {
    return mode_.node() + " has begun to lead and does not know of an order of " + former_->node() +
           " yet: " + former_->reason();
  }
  const auto because = [this] { return mode_.reason().empty() ? std::string() : ": " + mode_.reason(); };
  switch (what) {
    case ArmOrder::kUnheard:
      return mode_.term() == 0 ? "no supervisor was heard yet"
                               : "no supervisor was heard since this process was stopped and away";
    case ArmOrder::kStop:
      return (mode_.mode() == msg::Mode::MODE_STOP ? "the cell is stopped" : "the arm is stopped") + because();
    case ArmOrder::kHold:
      return (mode_.mode() == msg::Mode::MODE_HOLD ? "the cell is held" : "the arm is held") + because();
    case ArmOrder::kRun:
      break;
  }
  return {};
}

struct CellModeListener::Impl {
  Impl(bus::Participant& joined, bus::Mailbox* mailbox) : participant(joined), reader(joined, mailbox) {}
  const bus::Participant& participant;
  bus::Reader<msg::CellMode> reader;
  CellModeView view;
};

CellModeListener::CellModeListener(bus::Participant& participant, bus::Mailbox* mailbox)
    : impl_(std::make_unique<Impl>(participant, mailbox)) {}
CellModeListener::~CellModeListener() = default;

bool CellModeListener::update() {
  bool changed = false;
  for (const auto& sample : impl_->reader.take()) {
    if (!sample.disposed) changed = impl_->view.apply(sample.value, sample.received) || changed;
  }
  if (impl_->participant.away()) impl_->view.forget_order();
  return changed;
}

const CellModeView& CellModeListener::view() const {
  return impl_->view;
}
CellModeView& CellModeListener::view() {
  return impl_->view;
}

}  // namespace hecaton::services
