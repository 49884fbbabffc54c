#include "services/supervisor/detection/reachability_matrix.hpp"

#include <algorithm>

namespace hecaton::services {

ReachabilityMatrix::ReachabilityMatrix(std::vector<std::string> hosts, Time link_deadline, Time absence)
    : link_deadline_(link_deadline), absence_(absence) {
  for (std::string& host : hosts) {
    rows_.push_back({std::move(host)});
    rows_.back().ages.resize(hosts.size());
    rows_.back().found.resize(hosts.size());
  }
}

std::optional<HostIndex> ReachabilityMatrix::index(std::string_view host) const {
  const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.host == host; });
  if (found == rows_.end()) return std::nullopt;
  return static_cast<HostIndex>(found - rows_.begin());
}

void ReachabilityMatrix::take(HostIndex observer, const std::vector<HostAge>& ages, Time at) {
  Row& row = rows_[observer];
  if (row.at && at < *row.at) return;
  if (!row.at || at - *row.at >= link_deadline_) row.steady_since = at;
  if (!row.at || at - *row.at >= absence_) {
    row.returned = at;
    row.found.assign(rows_.size(), false);
  }
  row.at = at;
  row.ages.assign(rows_.size(), std::nullopt);
  for (const HostAge& heard : ages) {
    const auto subject = index(heard.host);
    if (!subject) continue;
    if (heard.age < link_deadline_) row.found[*subject] = true;
    if (row.found[*subject]) row.ages[*subject] = heard.age;
  }
}

bool ReachabilityMatrix::fresh(HostIndex observer, Time now) const {
  const Row& row = rows_[observer];
  return row.at && now - *row.at < link_deadline_;
}

bool ReachabilityMatrix::steady(HostIndex observer, Time now) const {
  return fresh(observer, now) && now - rows_[observer].steady_since >= link_deadline_;
}

std::optional<Time> ReachabilityMatrix::age(HostIndex observer, HostIndex subject, Time now) const {
  if (!fresh(observer, now) || !rows_[observer].ages[subject]) return std::nullopt;
  return *rows_[observer].ages[subject] + (now - *rows_[observer].at);
}

bool ReachabilityMatrix::hears(HostIndex observer, HostIndex subject, Time now) const {
  const auto age = this->age(observer, subject, now);
  return age && *age < link_deadline_;
}

}  // namespace hecaton::services
