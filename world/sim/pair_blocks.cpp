#include "world/sim/pair_blocks.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace hecaton::world {
namespace {

constexpr double kNoBound = -std::numeric_limits<double>::infinity();
/// Sums of many motions are rounded: a block's bound stays below its pairs' by more than that [m].
constexpr double kRounding = 1e-9;

}  // namespace

void PairBlocks::rebuild(std::span<const MonitoredPair> pairs, std::span<const int> side_of_part) {
  blocks_.clear();
  runs_.clear();
  std::map<std::pair<int, int>, int> index_of;  // by both sides
  int last = -1;
  for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
    const MonitoredPair& pair = pairs[i];
    const int a = side_of_part[pair.a];
    const int b = side_of_part[pair.b];
    if (last >= 0 && blocks_[last].a == a && blocks_[last].b == b) {
      runs_[last].back().end = i + 1;
      continue;
    }
    const auto [entry, is_new] = index_of.try_emplace({a, b}, static_cast<int>(blocks_.size()));
    last = entry->second;
    if (is_new) {
      blocks_.push_back({a, b, pair.kind, kNoBound});
      runs_.emplace_back();
    }
    runs_[last].push_back({i, i + 1});
  }
}

void PairBlocks::forget_bounds() {
  for (Block& block : blocks_) block.lower_ref = kNoBound;
}

std::span<const PairRun> PairBlocks::open(std::span<const double> travel,
                                          const std::array<double, kContactKinds>& smallest) {
  open_.clear();
  open_runs_.clear();
  for (int i = 0; i < static_cast<int>(blocks_.size()); ++i) {
    const Block& block = blocks_[i];
    const double lower = block.lower_ref - (travel[block.a] + travel[block.b]);
    if (lower > 0.0 && lower >= smallest[static_cast<std::size_t>(block.kind)]) continue;
    open_.push_back(i);
    open_runs_.insert(open_runs_.end(), runs_[i].begin(), runs_[i].end());
  }
  // Of two pairs at the same distance the account names the first.
  std::sort(open_runs_.begin(), open_runs_.end(),
            [](const PairRun& one, const PairRun& other) { return one.first < other.first; });
  return open_runs_;
}

void PairBlocks::close(std::span<const MonitoredPair> pairs, std::span<const double> part_travel,
                       std::span<const double> travel) {
  for (const int i : open_) {
    Block& block = blocks_[i];
    double lower = std::numeric_limits<double>::infinity();
    for (const PairRun& run : runs_[i]) {
      for (const MonitoredPair& pair : pairs.subspan(run.first, run.end - run.first)) {
        const double own = pair.lower_ref - (part_travel[pair.a] + part_travel[pair.b]);
        lower = std::min(lower, pair.state.watched() ? kNoBound : own);
      }
    }
    block.lower_ref = lower + (travel[block.a] + travel[block.b]) - kRounding;
  }
}

}  // namespace hecaton::world
