#include "planner/methods/sensed_cspace/published/image_database.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::cspace {
namespace {

/// How far θ₁ may turn away from the direction of a point at distance r and the arm can still touch it [rad]; below 0
/// if it never can. [Li96] eq. 3 with s = l₂; what the first link touches is added.
double widest_theta1(const PlanarArm& arm, double r) {
  const double l1 = arm.length1;
  const double l2 = arm.length2;
  double widest = r <= l1 ? std::asin(std::min(1.0, arm.width1 / r)) : -1.0;
  if (r <= l1 + l2 && r >= std::abs(l1 - l2)) {
    widest = std::max(widest, std::acos(std::clamp((r * r + l1 * l1 - l2 * l2) / (2.0 * l1 * r), -1.0, 1.0)));
  } else if (r < l2 - l1) {
    widest = kPi;
  }
  return widest;
}

}  // namespace

// [Li96] eq. 3–6 for a point at (r, 0), row by row: with the elbow at θ₁, s and θ₂ are the distance and the direction
// of the point, and the second link touches it from θ₂ − asin(w/s) to θ₂ + asin(w/s). differs from paper: eq. 4 lacks
// l₂ and the sign's rule; θ₂ follows from the elbow's place instead. Where the first link touches the point ("very
// simple" in the paper) or the elbow is within w of it, every θ₂ does.
ImageDatabase::ImageDatabase(const PlanarArm& arm, AngleGrid grid, int images)
    : grid_(grid), spacing_(arm.reach() / images) {
  for (int k = 1; k <= images; ++k) {
    const double r = k * spacing_;
    PointImage& image = images_.emplace_back();
    const double widest = widest_theta1(arm, r);
    if (widest < 0.0) continue;
    image.theta1_min = -widest;
    image.theta1_max = widest;
    const int rows = static_cast<int>(std::ceil(2.0 * widest / grid.pitch())) + 1;
    for (int row = 0; row < rows; ++row) {
      const double theta1 = std::min(image.theta1_min + row * grid.pitch(), widest);
      const double x = r * std::cos(theta1) - arm.length1;
      const double y = -r * std::sin(theta1);
      const double s = std::hypot(x, y);
      const bool first_link = r <= arm.length1 && std::abs(y) <= arm.width1 && x <= 0.0 && std::cos(theta1) > 0.0;
      const double theta2 = std::atan2(y, x);
      const double half = s > arm.width2 ? std::asin(arm.width2 / s) : kPi;
      const bool all = first_link || half == kPi;
      image.lower.push_back(all ? -kPi : theta2 - half);
      image.upper.push_back(all ? kPi : theta2 + half);
    }
  }
}

const PointImage& ImageDatabase::at(double r) const {
  static const PointImage kOutOfReach;
  const double n = std::max(1.0, std::floor(r / spacing_));
  return n > size() ? kOutOfReach : images_[static_cast<std::size_t>(n) - 1];
}

std::size_t ImageDatabase::bytes() const {
  std::size_t bytes = images_.size() * sizeof(PointImage);
  for (const PointImage& image : images_) bytes += (image.lower.size() + image.upper.size()) * sizeof(double);
  return bytes;
}

}  // namespace hecaton::planner::cspace
