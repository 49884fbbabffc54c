#pragma once
/// Random shapes and poses of the sizes that cells are made of, from a caller's generator.

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "world/model/shape.hpp"

namespace hecaton::test {

using Random = std::mt19937_64;

enum class Kind { kBox, kSphere, kCapsule, kCylinder, kConvex };
inline constexpr int kKinds = 5;
inline const char* const kKindNames[] = {"Box", "Sphere", "Capsule", "Cylinder", "Convex"};

/// The octahedron-like hull ±a x, ±b y, ±c z, shifted by `centre`: 6 vertices, 8 faces.
inline world::Convex octahedron(const Eigen::Vector3d& half, const Eigen::Vector3d& centre) {
  auto hull = std::make_shared<world::ConvexHull>();
  for (int axis = 0; axis < 3; ++axis) {
    hull->vertices.emplace_back(centre + half[axis] * Eigen::Vector3d::Unit(axis));
    hull->vertices.emplace_back(centre - half[axis] * Eigen::Vector3d::Unit(axis));
  }
  for (int x : {0, 1}) {
    for (int y : {2, 3}) {
      for (int z : {4, 5}) {
        const bool even = (x + y + z) % 2 == 0;
        hull->faces.push_back(even ? std::vector<int>{x, y, z} : std::vector<int>{x, z, y});
      }
    }
  }
  return {hull};
}

/// A prism of n sides: two n-gons at z = ±half_length around `centre`, joined by quadrilaterals.
inline world::Convex prism(int sides, double radius, double half_length, const Eigen::Vector3d& centre) {
  auto hull = std::make_shared<world::ConvexHull>();
  std::vector<int> top;
  std::vector<int> bottom;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    const Eigen::Vector3d rim(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    hull->vertices.emplace_back(centre + rim - half_length * Eigen::Vector3d::UnitZ());
    hull->vertices.emplace_back(centre + rim + half_length * Eigen::Vector3d::UnitZ());
    const int next = (i + 1) % sides;
    hull->faces.push_back({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
    top.push_back(2 * i + 1);
    bottom.insert(bottom.begin(), 2 * i);
  }
  hull->faces.push_back(top);
  hull->faces.push_back(bottom);
  return {hull};
}

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Eigen::Vector3d random_vector(Random& random, double low, double high) {
  const double x = uniform(random, low, high);
  const double y = uniform(random, low, high);
  return {x, y, uniform(random, low, high)};
}

inline world::Shape random_shape(Kind kind, Random& random) {
  switch (kind) {
    case Kind::kBox:
      return world::Box{random_vector(random, 0.02, 0.4)};
    case Kind::kSphere:
      return world::Sphere{uniform(random, 0.02, 0.3)};
    case Kind::kCapsule:
      return world::Capsule{uniform(random, 0.02, 0.15), uniform(random, 0.0, 0.4)};
    case Kind::kCylinder:
      return world::Cylinder{uniform(random, 0.02, 0.3), uniform(random, 0.02, 0.4)};
    case Kind::kConvex:
      break;
  }
  if (uniform(random, 0.0, 1.0) < 0.5) {
    const Eigen::Vector3d half = random_vector(random, 0.03, 0.4);
    return octahedron(half, random_vector(random, -0.05, 0.05));
  }
  const int sides = std::uniform_int_distribution<int>(3, 40)(random);
  const double radius = uniform(random, 0.03, 0.3);
  const double half_length = uniform(random, 0.03, 0.3);
  return prism(sides, radius, half_length, random_vector(random, -0.05, 0.05));
}

/// Uniformly random orientation; position in the cube of ±reach [m].
inline world::Pose random_pose(Random& random, double reach) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q;
  for (int i = 0; i < 4; ++i) q.coeffs()[i] = normal(random);
  world::Pose pose = world::Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = random_vector(random, -reach, reach);
  return pose;
}

inline Eigen::Vector3d random_direction(Random& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random);
  const double y = normal(random);
  return Eigen::Vector3d(x, y, normal(random)).normalized();
}

}  // namespace hecaton::test
