#include <algorithm>
#include <limits>

#include "world/sim/monitored_pairs.hpp"

namespace hecaton::world {
namespace {

constexpr double kNoReach = std::numeric_limits<double>::infinity();
/// A larger skin is used up more rarely, and has more pairs in it [m].
constexpr double kSkin = 0.05;
/// Sums of many motions are rounded [m].
constexpr double kTravelError = 1e-9;

int standing_of(const MonitoredPair& pair, int mover) {
  return pair.a == mover ? pair.b : pair.a;
}

}  // namespace

void NearPairs::clear(int parts) {
  tree_.clear();
  boxes_.assign(static_cast<std::size_t>(parts), {});
  any_standing_ = false;
  lists_.assign(static_cast<std::size_t>(parts), {});
  found_.assign(static_cast<std::size_t>(parts), {});
}

void NearPairs::keep(const MonitoredPairs& all, int mover, int standing, const PairState& state) {
  auto& list = lists_[static_cast<std::size_t>(mover)];
  const auto place = std::lower_bound(list.begin(), list.end(), standing, [&](const MonitoredPair& pair, int wanted) {
    return standing_of(pair, mover) < wanted;
  });
  if (place != list.end() && standing_of(*place, mover) == standing) {
    place->state = state;
  } else {
    list.insert(place, all.near_pair(mover, standing))->state = state;
  }
}

void NearPairs::put(const MonitoredPairs& all, int standing) {
  BoundingBox& box = boxes_[static_cast<std::size_t>(standing)];
  box = all.box(standing);
  tree_.put(standing, box);
  any_standing_ = true;
  expire();
}

double NearPairs::least_distance(const MonitoredPairs& all) const {
  double least = kNoReach;
  MonitoredPair nearest;
  for (const int mover : all.movers()) {
    if (!all.placed(mover)) continue;
    const MonitoredPart& moving = all.part(mover);
    const auto& list = lists_[static_cast<std::size_t>(mover)];
    auto kept = list.begin();
    for (int i = 0; i < all.part_count(); ++i) {
      const MonitoredPart& standing = all.part(i);
      if (!standing.stands() || !all.placed(i)) continue;
      while (kept != list.end() && standing_of(*kept, mover) < i) ++kept;
      const bool known = kept != list.end() && standing_of(*kept, mover) == i;
      if (known && (kept->state.handled || kept->state.tolerated)) continue;  // may not count
      const double bound = (moving.centre_W - standing.centre_W).norm() - moving.radius - standing.radius;
      if (bound >= least) continue;
      least = bound;
      nearest = all.near_pair(mover, i);
    }
  }
  return least == kNoReach ? kNoReach : all.exact_distance(nearest) + kDistanceError;
}

void NearPairs::find(const MonitoredPairs& all, int mover, double reach) {
  near_.clear();
  within(all, mover, reach, [&](int standing) { near_.push_back(standing); });
  std::sort(near_.begin(), near_.end());
  auto& list = lists_[static_cast<std::size_t>(mover)];
  std::vector<MonitoredPair> next;
  next.reserve(near_.size());
  auto kept = list.begin();
  const auto keep_watched = [&](int before) {
    for (; kept != list.end() && standing_of(*kept, mover) < before; ++kept) {
      if (kept->state.watched()) next.push_back(*kept);
    }
  };
  for (const int standing : near_) {
    keep_watched(standing);
    if (kept != list.end() && standing_of(*kept, mover) == standing) {
      next.push_back(*kept++);
    } else {
      next.push_back(all.near_pair(mover, standing));
    }
  }
  keep_watched(all.part_count());
  list = std::move(next);
  found_[static_cast<std::size_t>(mover)] = {reach, all.travel(mover)};
}

void NearPairs::candidates(const MonitoredPairs& all, double smallest, std::vector<MonitoredPair*>& out) {
  if (!any_standing()) return;
  double reach = std::max(smallest, 0.0);
  if (reach == kNoReach) {
    reach = std::max(least_distance(all), 0.0);
    if (reach == kNoReach) reach = 0.0;  // watched pairs only
    expire();
  }
  for (const int mover : all.movers()) {
    if (!all.placed(mover)) continue;
    const double travel = all.travel(mover);
    const Found& found = found_[static_cast<std::size_t>(mover)];
    if (found.reach - (travel - found.travel) < reach + kTravelError) find(all, mover, reach + kSkin);
    for (MonitoredPair& pair : lists_[static_cast<std::size_t>(mover)]) {
      const double lower = pair.lower_ref - all.travel(pair);
      if (pair.state.watched() || lower <= 0.0 || lower < smallest) out.push_back(&pair);
    }
  }
}

}  // namespace hecaton::world
