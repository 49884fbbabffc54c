#pragma once
/// The collision kernel: checks eight configurations at a time. It reads robot and world as plain floats in one frame,
/// built once per scene. Compiled once per instruction set, so this header has no inline code.

#include <array>
#include <cstdint>
#include <vector>

namespace hecaton::planner::global {

/// Lanes. A configuration is a row of floats, padded with zeros to a whole number of lanes.
inline constexpr int kWidth = 8;
inline constexpr int kMaxDimensions = 48;  ///< joints of all planned arms together
inline constexpr int kMaxFrames = kMaxDimensions;
inline constexpr int kMaxBodies = 512;
inline constexpr int kMaxSpheres = 4096;

/// A moving joint and the frame behind it. The joint moves about or along the z axis of that frame.
struct KernelFrame {
  int parent = -1;  ///< index of an earlier frame; −1: the world
  bool prismatic = false;
  std::array<float, 9> rotation{};     ///< of the joint's frame in the parent, column by column
  std::array<float, 3> translation{};  ///< [m]
};

struct KernelSphere {
  std::array<float, 3> centre{};  ///< in the body's frame [m]
  float radius = 0.0F;            ///< [m]
  float inner = 0.0F;             ///< the sphere of this radius about the centre lies within the shape [m]
};

/// A convex part of a link: its bounding sphere, and the spheres that cover it.
struct KernelBody {
  int frame = -1;  ///< −1: fixed
  KernelSphere bound;
  int first = 0;  ///< index into KernelRobot::spheres
  int count = 0;
};

struct KernelPair {
  int a = 0;  ///< index into KernelRobot::bodies
  int b = 0;
  float padding = 0.0F;  ///< distance to keep between the two [m]
};

/// All planned arms as one robot.
struct KernelRobot {
  int dimensions = 0;
  std::vector<KernelFrame> frames;  ///< parents before children; frame i is moved by coordinate i
  std::vector<KernelBody> bodies;
  std::vector<KernelSphere> spheres;
  std::vector<KernelPair> pairs;  ///< pairs of bodies that must not touch
  std::vector<int> order;         ///< the bodies that move, the most likely to collide first
};

enum class ObstacleKind : std::uint8_t { kBox, kSphere, kCapsule, kCylinder, kConvex };

struct KernelObstacle {
  ObstacleKind kind = ObstacleKind::kBox;
  std::array<float, 9> axes{};    ///< unit axes, one after the other
  std::array<float, 3> centre{};  ///< [m]
  std::array<float, 3> half{};  ///< box: half extents; capsule, cylinder: radius, –, half length; sphere: radius [m]
  int first = 0;                ///< convex: index into KernelWorld::planes
  int count = 0;
  std::array<float, 3> bound_centre{};  ///< of the bounding sphere [m]
  float bound_radius = 0.0F;            ///< [m]
};

/// Half space n · x ≤ offset.
struct KernelPlane {
  std::array<float, 3> normal{};
  float offset = 0.0F;  ///< [m]
};

struct KernelWorld {
  float padding = 0.0F;  ///< distance to keep from all obstacles [m]
  std::vector<KernelObstacle> obstacles;
  std::vector<KernelPlane> planes;
  /// Axis-aligned boxes of the obstacles, eight at a time: minimum x, y, z, then maximum x, y, z [m]. Unused lanes hold
  /// boxes that no body meets.
  std::vector<std::array<std::array<float, kWidth>, 6>> boxes;
};

/// Exact distances of shapes, for pairs that spheres do not decide. The functions return a lower bound, rounding
/// included [m]. `frame`: four columns of x, y, z: the axes and the origin.
struct ExactCheck {
  const void* context = nullptr;
  double (*from_obstacle)(const void* context, int body, const float* frame, int obstacle) = nullptr;
  double (*from_body)(const void* context, int a, const float* frame_a, int b, const float* frame_b) = nullptr;
};

/// A segment of a path is free if all bodies at its midpoint, enlarged by their motion on the segment, are free.
struct KernelSweep {
  const float* growth = nullptr;       ///< by body: no point moves farther from its place at the midpoint [m]
  const float* pair_growth = nullptr;  ///< by pair: the same, of one body relative to the other [m]
  float padding = 0.0F;                ///< distance to keep from the world [m]
  bool exact = true;                   ///< use exact distances where spheres do not decide
};

/// Bits of lanes: the midpoint collides, and the segment around it may collide.
struct SweepHits {
  unsigned sure = 0;
  unsigned maybe = 0;
};

struct ValidityKernel {
  /// Bit i: configuration i of eight collides. Configurations are `stride` floats apart.
  unsigned (*collisions)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const float* q, int stride);
  /// True if none of 8 · `blocks` configurations, evenly spaced on the straight line from a (excluded) to b (included),
  /// collides. Each block spreads over the whole line, so that an obstacle is found early.
  bool (*edge_free)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const float* a, const float* b,
                    int blocks);
  /// Checks eight segments, whose midpoints are these configurations. Returns as soon as one midpoint collides.
  SweepHits (*swept)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const KernelSweep&, const float* q,
                     int stride);
};

/// The kernel for this processor.
[[nodiscard]] const ValidityKernel& fastest_validity();

namespace baseline {
extern const ValidityKernel kValidity;
}
namespace avx2 {
extern const ValidityKernel kValidity;
}

}  // namespace hecaton::planner::global
