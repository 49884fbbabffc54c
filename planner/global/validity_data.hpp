#pragma once
/// What the validity kernel reads: robots and world as plain floats, in one frame, all of it built once per scene.

#include <array>
#include <cstdint>
#include <vector>

namespace hecaton::planner::global {

/// Configurations are floats, padded with zeros to a whole number of lanes.
inline constexpr int kWidth = 8;
inline constexpr int kMostDimensions = 48;  ///< joints of all planned arms together
inline constexpr int kMostFrames = kMostDimensions;
inline constexpr int kMostBodies = 512;
inline constexpr int kMostBalls = 4096;

/// A moving joint and the frame behind it. Frames are turned so that every joint moves about or along its own z.
struct KernelFrame {
  int parent = -1;  ///< an earlier frame; −1: the world
  bool shifts = false;
  std::array<float, 9> rotation{};     ///< of the joint's frame in the parent, column by column
  std::array<float, 3> translation{};  ///< [m]
};

struct KernelBall {
  std::array<float, 3> centre{};  ///< in its body's frame [m]
  float radius = 0.0F;            ///< [m]
  float inner = 0.0F;             ///< a ball of this radius around the same centre lies within the shape [m]
};

/// A convex piece of a link: a ball around it, and the balls that cover it.
struct KernelBody {
  int frame = -1;  ///< −1: no joint moves it
  KernelBall bound;
  int first = 0;  ///< of KernelRobot::balls
  int count = 0;
};

struct KernelPair {
  int a = 0;  ///< of KernelRobot::bodies
  int b = 0;
  float padding = 0.0F;  ///< distance to be kept between the two [m]
};

/// One or several robots that are planned as one.
struct KernelRobot {
  int dimensions = 0;
  std::vector<KernelFrame> frames;  ///< parents before children; frame i is moved by coordinate i
  std::vector<KernelBody> bodies;
  std::vector<KernelBall> balls;
  std::vector<KernelPair> pairs;  ///< of bodies that must not touch
  std::vector<int> order;         ///< the moved bodies, those that are likely to hit first
};

enum class ObstacleKind : std::uint8_t { kBox, kSphere, kCapsule, kCylinder, kConvex };

struct KernelObstacle {
  ObstacleKind kind = ObstacleKind::kBox;
  std::array<float, 9> axes{};    ///< its unit axes, one after the other
  std::array<float, 3> centre{};  ///< [m]
  std::array<float, 3> half{};  ///< box: half extents; capsule, cylinder: radius, –, half length; sphere: radius [m]
  int first = 0;                ///< convex: of KernelWorld::planes
  int count = 0;
  std::array<float, 3> middle{};  ///< a ball of radius `reach` around this encloses it [m]
  float reach = 0.0F;
};

/// n · x − offset > 0 outside.
struct KernelPlane {
  std::array<float, 3> normal{};
  float offset = 0.0F;  ///< [m]
};

struct KernelWorld {
  float padding = 0.0F;  ///< distance to be kept from all of it [m]
  std::vector<KernelObstacle> obstacles;
  std::vector<KernelPlane> planes;
  /// Axis-parallel boxes around the obstacles, eight of them at a time: least x, y, z, then greatest x, y, z. Filled up
  /// with boxes that nothing meets.
  std::vector<std::array<std::array<float, kWidth>, 6>> boxes;
};

/// Decides where balls cannot: how far a body's own shape, at the pose that a frame gives it in one lane, is at least
/// away, whatever rounding costs [m]. Frames are four columns of x, y, z: the axes and the origin.
struct ExactCheck {
  const void* context = nullptr;
  double (*from_obstacle)(const void* context, int body, const float* frame, int obstacle) = nullptr;
  double (*from_body)(const void* context, int a, const float* frame_a, int b, const float* frame_b) = nullptr;
};

/// A stretch of a way is free when its middle is and all bodies there, made larger by how far they move on it, are.
struct KernelSweep {
  const float* growth = nullptr;       ///< by body: no point of it is farther from where it is in the middle [m]
  const float* pair_growth = nullptr;  ///< by pair: the same of one body as seen from the other [m]
  float padding = 0.0F;                ///< distance to be kept from the world [m]
  bool exact = true;                   ///< ask for exact distances where balls do not tell
};

/// Lanes in which the middle collides, and those in which the stretch around it may.
struct SweepHits {
  unsigned sure = 0;
  unsigned maybe = 0;
};

}  // namespace hecaton::planner::global
