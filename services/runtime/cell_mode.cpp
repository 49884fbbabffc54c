#include "services/runtime/cell_mode.hpp"

#include <algorithm>

#include "services/bus/endpoint.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services {
namespace {

/// The stricter of the cell's mode and the arm's own.
msg::Mode mode_in(const msg::CellMode& mode, std::string_view arm) {
  const msg::ArmOrder* own = order_in(mode, arm);
  return own == nullptr ? mode.mode() : std::max(mode.mode(), own->mode());
}

/// The same for the operators' orders alone, without holds by faults.
msg::Mode ordered_in(const msg::CellMode& mode, std::string_view arm) {
  const msg::ArmOrder* own = order_in(mode, arm);
  return own == nullptr ? mode.ordered() : std::max(mode.ordered(), own->ordered());
}

/// True when `mode` has all operator orders of `former`, at least as strict.
bool knows_orders_of(const msg::CellMode& former, const msg::CellMode& mode) {
  return beyond(orders_in(former), orders_in(mode)).empty();
}

}  // namespace

msg::ModeNumber number_of(const msg::CellMode& mode) {
  msg::ModeNumber number;
  number.term(mode.term());
  number.sequence_number(mode.sequence_number());
  return number;
}

// Within a term the latest arrival counts, not the highest sequence number: a restarted supervisor counts from one
// again.
bool CellModeView::apply(const msg::CellMode& mode, bus::Clock::time_point received, const bus::EndpointId& writer) {
  if (mode.term() < term_) return false;
  if (heard_ && mode.term() == term_ && !writer.same_participant(writer_) && received - received_ <= kHold)
    return false;
  if (mode.term() > term_ && !former_) {
    if (!knows_orders_of(mode_, mode)) former_ = mode_;
    changed_ = received;
  }
  if (former_ && (received - changed_ >= kOrderHandover || knows_orders_of(*former_, mode))) former_.reset();
  heard_ = true;
  term_ = mode.term();
  mode_ = mode;
  received_ = received;
  writer_ = writer;
  return true;
}

ArmLease CellModeView::lease(std::string_view arm) const {
  for (const msg::ArmLease& lease : mode_.leases()) {
    if (lease.arm() == arm) return lease_of(lease);
  }
  return {{}, term_};
}

const msg::LostArm* CellModeView::lost(std::string_view arm) const {
  if (!heard_) return nullptr;
  const auto& lost = mode_.lost_arms();
  const auto found = std::find_if(lost.begin(), lost.end(), [&](const msg::LostArm& one) { return one.arm() == arm; });
  return found == lost.end() ? nullptr : &*found;
}

msg::Mode CellModeView::order(std::string_view arm) const {
  if (!heard_) return msg::Mode::MODE_HOLD;
  const msg::Mode now = mode_in(mode_, arm);
  return former_ ? std::max(now, ordered_in(*former_, arm)) : now;
}

double CellModeView::speed(std::string_view arm) const {
  if (!heard_ && term_ == 0) return kSlowestSpeed;
  const double now = speed_in(mode_, arm);
  return former_ ? std::min(now, speed_in(*former_, arm)) : now;
}

msg::Cause CellModeView::why(std::string_view arm) const {
  if (!heard_) {
    return make_cause(
        msg::CauseKind::CAUSE_MODE_UNKNOWN, {},
        mode_.term() == 0 ? "no cell mode received yet" : "no cell mode received since this process was stalled");
  }
  const msg::Mode what = order(arm);
  if (what == msg::Mode::MODE_RUN) return {};
  const bool stop = what == msg::Mode::MODE_STOP;
  if (what != mode_in(mode_, arm)) {
    return make_cause(stop ? msg::CauseKind::CAUSE_STOP_ORDERED : msg::CauseKind::CAUSE_HOLD_ORDERED, std::string(arm),
                      mode_.node() + " leads now and does not know an order of " + former_->node() +
                          " yet: " + causes_text(*former_));
  }
  const bool whole_cell = mode_.mode() == what;
  msg::Cause cause = whole_cell ? mode_.cause() : order_in(mode_, arm)->cause();
  const std::string head = std::string(whole_cell ? "the cell" : "the arm") + (stop ? " is stopped" : " is held");
  if (is_none(cause)) {
    return make_cause(stop ? msg::CauseKind::CAUSE_STOP_ORDERED : msg::CauseKind::CAUSE_HOLD_ORDERED, {}, head);
  }
  cause.text(head + ": " + cause.text());
  return cause;
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
    if (!sample.disposed) changed = impl_->view.apply(sample.value, sample.received, sample.writer) || changed;
  }
  if (impl_->participant.recovering()) impl_->view.forget_order();
  return changed;
}

const CellModeView& CellModeListener::view() const {
  return impl_->view;
}
CellModeView& CellModeListener::view() {
  return impl_->view;
}

}  // namespace hecaton::services
