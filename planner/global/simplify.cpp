#include "planner/global/simplify.hpp"

#include <algorithm>

namespace hecaton::planner::global {
namespace {

/// What edges keep from the world, best first: shares of the wanted clearance.
constexpr double kGrades[] = {1.0, 0.25, 0.0};
constexpr int kWorst = 2;

/// A point of the path and the edge it lies on.
struct Place {
  int edge;
  float t;
};

class Shortcutter {
 public:
  Shortcutter(const Points& path, const Validity& validity, const Space& space, const SimplifyOptions& options)
      : path_(path), validity_(validity), space_(space), options_(options), one_(space.stride), two_(space.stride) {
    for (int i = 0; i + 1 < path_.size(); ++i) grades_.push_back(grade_of(path_[i], path_[i + 1]));
  }

  /// Every point is joined with the farthest one that it sees.
  void join_farthest() {
    Points result(path_.stride());
    std::vector<int> grades;
    result.add(path_[0]);
    for (int from = 0; from + 1 < path_.size();) {
      int to = path_.size() - 1;
      while (to > from + 1 && (ended() || !keeps(path_[from], path_[to], worst(from, to)))) --to;
      result.add(path_[to]);
      grades.push_back(to == from + 1 ? grades_[from] : worst(from, to));
      from = to;
    }
    path_ = std::move(result);
    grades_ = std::move(grades);
  }

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
    const int grade = worst(from.edge, to.edge + 1);
    if (!keeps(one_.data(), two_.data(), grade)) return;
    // Parts of edges that were looked at in places are looked at again: the places fall elsewhere.
    if (!options_.check.proven) {
      if (!keeps(path_[from.edge], one_.data(), grades_[from.edge])) return;
      if (!keeps(two_.data(), path_[to.edge + 1], grades_[to.edge])) return;
    }
    Points shorter(path_.stride());
    std::vector<int> grades(grades_.begin(), grades_.begin() + from.edge + 1);
    for (int i = 0; i <= from.edge; ++i) shorter.add(path_[i]);
    shorter.add(one_.data());
    shorter.add(two_.data());
    grades.push_back(grade);
    for (int i = to.edge + 1; i < path_.size(); ++i) shorter.add(path_[i]);
    grades.insert(grades.end(), grades_.begin() + to.edge, grades_.end());
    path_ = std::move(shorter);
    grades_ = std::move(grades);
  }
  [[nodiscard]] const Points& path() const { return path_; }
  [[nodiscard]] bool ended() const { return options_.ended && options_.ended(); }

 private:
  [[nodiscard]] bool keeps(const float* a, const float* b, int grade) const {
    EdgeCheck check = options_.check;
    check.clearance += kGrades[grade] * options_.clearance;
    check.proven = check.proven || check.clearance > 0.0;
    return check.free(validity_, a, b);
  }
  [[nodiscard]] int grade_of(const float* a, const float* b) const {
    int grade = options_.clearance > 0.0 ? 0 : kWorst;
    while (grade < kWorst && (ended() || !keeps(a, b, grade))) ++grade;
    return grade;
  }
  /// Of the edges from point `from` to point `to`.
  [[nodiscard]] int worst(int from, int to) const {
    return *std::max_element(grades_.begin() + from, grades_.begin() + to);
  }
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
  std::vector<int> grades_;  ///< of the edges: indices of kGrades
  const Validity& validity_;
  const Space& space_;
  const SimplifyOptions& options_;
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
  Shortcutter shortcutter(path, validity, space, options);
  shortcutter.join_farthest();
  Random random(options.seed);
  for (int i = 0; i < options.rounds && shortcutter.path().size() > 2 && !shortcutter.ended(); ++i)
    shortcutter.try_once(random);
  shortcutter.join_farthest();
  return shortcutter.path();
}

}  // namespace hecaton::planner::global
