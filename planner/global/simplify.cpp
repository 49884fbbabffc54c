#include "planner/global/simplify.hpp"

#include <algorithm>

namespace hecaton::planner::global {
namespace {

Points farthest_seen(const Points& path, const Validity& validity, int finer) {
  Points result(path.stride());
  result.add(path[0]);
  for (int from = 0; from + 1 < path.size();) {
    int to = path.size() - 1;
    while (to > from + 1 && !validity.edge_free(path[from], path[to], finer)) --to;
    result.add(path[to]);
    from = to;
  }
  return result;
}

/// A point of the path and the edge it lies on.
struct Place {
  int edge;
  float t;
};

class Shortcutter {
 public:
  Shortcutter(Points path, const Validity& validity, const Space& space, int finer)
      : path_(std::move(path)),
        validity_(validity),
        space_(space),
        finer_(finer),
        one_(space.stride),
        two_(space.stride) {}

  void try_once(Random& random) {
    const double whole = length(path_, space_);
    double s = random.uniform() * whole;
    double t = random.uniform() * whole;
    if (s > t) std::swap(s, t);
    const Place from = place(s);
    const Place to = place(t);
    if (from.edge == to.edge) return;
    space_.interpolate(path_[from.edge], path_[from.edge + 1], from.t, one_.data());
    space_.interpolate(path_[to.edge], path_[to.edge + 1], to.t, two_.data());
    if (!validity_.edge_free(one_.data(), two_.data(), finer_)) return;
    // Parts of checked edges are checked again: their configurations fall elsewhere.
    if (!validity_.edge_free(path_[from.edge], one_.data(), finer_)) return;
    if (!validity_.edge_free(two_.data(), path_[to.edge + 1], finer_)) return;
    Points shorter(path_.stride());
    for (int i = 0; i <= from.edge; ++i) shorter.add(path_[i]);
    shorter.add(one_.data());
    shorter.add(two_.data());
    for (int i = to.edge + 1; i < path_.size(); ++i) shorter.add(path_[i]);
    path_ = std::move(shorter);
  }
  [[nodiscard]] const Points& path() const { return path_; }

 private:
  [[nodiscard]] Place place(double at) const {
    for (int edge = 0; edge + 1 < path_.size(); ++edge) {
      const double part = space_.distance(path_[edge], path_[edge + 1]);
      if (at <= part || edge + 2 == path_.size()) {
        return {edge, part > 0.0 ? static_cast<float>(std::min(1.0, at / part)) : 0.0F};
      }
      at -= part;
    }
    return {0, 0.0F};
  }

  Points path_;
  const Validity& validity_;
  const Space& space_;
  int finer_;
  std::vector<float> one_;
  std::vector<float> two_;
};

}  // namespace

double length(const Points& path, const Space& space) {
  double sum = 0.0;
  for (int i = 0; i + 1 < path.size(); ++i) sum += space.distance(path[i], path[i + 1]);
  return sum;
}

Points simplified(const Points& path, const Validity& validity, const Space& space, const SimplifyOptions& options) {
  if (path.size() <= 2) return path;
  Shortcutter shortcutter(farthest_seen(path, validity, options.finer), validity, space, options.finer);
  Random random(options.seed);
  for (int i = 0; i < options.rounds && shortcutter.path().size() > 2; ++i) shortcutter.try_once(random);
  return farthest_seen(shortcutter.path(), validity, options.finer);
}

}  // namespace hecaton::planner::global
