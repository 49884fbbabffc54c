#include "services/supervisor/detection/packet_loss_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::services {
namespace {

/// A count that has faded to less than this part of a sample says nothing any more.
constexpr double kFaded = 0.1;

}  // namespace

void PacketLossEstimator::expect(const std::string& sender, const std::string& host) {
  senders_[sender].way = host == own_ ? nullptr : &hosts_[host];
}

void PacketLossEstimator::arrived(std::string_view sender, std::int64_t process, std::uint64_t number) {
  const auto found = senders_.find(sender);
  if (found == senders_.end() || !found->second.way || number == 0) return;
  Sender& from = found->second;
  const bool goes_on = from.process == process && number > from.number;
  const std::uint64_t missing = goes_on ? number - from.number - 1 : 0;
  from.process = process;
  from.number = number;
  // More in a row are no losses: the sender or the observer was away.
  const bool believable = missing <= static_cast<std::uint64_t>(longest_row(kMostLost));
  const double lost = believable ? static_cast<double>(missing) : 0.0;
  from.way->count(clock_.now(), lost);
  all_.count(clock_.now(), lost);
}

double PacketLossEstimator::lost(std::string_view host, const Late& late) const {
  const auto way = hosts_.find(host);
  if (way == hosts_.end()) return 0.0;
  const Time now = clock_.now();
  return std::min(kMostLost, std::max(way->second.share_lost(now, late.host), all_.share_lost(now, late.all)));
}

int PacketLossEstimator::longest_row(double lost) {
  return lost <= 0.0 ? 0 : static_cast<int>(std::ceil(std::log(kRare) / std::log(lost)));
}

void PacketLossEstimator::Tally::count(Time now, double lost) {
  const double left = this->left(now);
  received_ = received_ * left + 1.0;
  lost_ = lost_ * left + lost;
  at_ = now;
}

double PacketLossEstimator::Tally::share_lost(Time now, int late) const {
  const double left = this->left(now);
  const double lost = lost_ * left + late;
  return lost < kFaded ? 0.0 : lost / (received_ * left + lost);
}

double PacketLossEstimator::Tally::left(Time now) const {
  if (now == at_) return 1.0;  // mostly: a turn's samples come together
  return std::exp(-std::chrono::duration<double>(now - at_) / std::chrono::duration<double>(fades_));
}

void PacketLossEstimator::Way::count(Time now, double lost) {
  lately.count(now, lost);
  before.count(now, lost);
}

double PacketLossEstimator::Way::share_lost(Time now, int late) const {
  return std::max(lately.share_lost(now, late), before.share_lost(now, late));
}

}  // namespace hecaton::services
