#pragma once
/// The collision kernel: checks configurations and edges in lanes of floats. It reads robot and world as plain numbers
/// in one frame O, built once per scene. Compiled once per instruction set, so this header has no inline code.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hecaton::world {
struct PointNode;
struct PointLeaf;
}  // namespace hecaton::world

namespace hecaton::planner::global {

/// Configurations of one batch of ValidityKernel::collisions. A configuration is a row of floats, padded with zeros to
/// a multiple of this.
inline constexpr int kWidth = 8;
inline constexpr int kMaxDimensions = 48;  ///< joints of all planned arms together
inline constexpr int kMaxFrames = 64;      ///< moving links, of followers too
inline constexpr int kMaxBodies = 512;
inline constexpr int kMaxBalls = 8192;
/// Rows of tables are padded to this many floats, the widest lanes.
inline constexpr int kTablePadding = 16;

/// A moving link's joint and the frame behind it. The joint moves about or along the z axis of that frame.
struct KernelFrame {
  int parent = -1;      ///< index of an earlier frame; −1: the world
  int coordinate = -1;  ///< the frame moves by this coordinate, or by multiplier · coordinate + offset if it follows
  bool prismatic = false;
  bool follows = false;
  float multiplier = 1.0F;
  float offset = 0.0F;
  std::array<float, 9> rotation{};     ///< of the joint's frame in the parent, column by column
  std::array<float, 3> translation{};  ///< [m]
  /// Each column of `rotation` is a unit axis of the parent: its index, and its sign. −1: it is not.
  std::array<int, 3> axis{-1, -1, -1};
};

/// A ball in its frame. The balls of a link form a tree in preorder: the balls of a subtree follow its root, up to
/// `next`. A leaf's `next` is its own index + 1. A root contains the shapes below it; the leaves of a body together
/// contain its shape.
struct KernelBall {
  std::array<float, 3> centre{};  ///< [m]
  float radius = 0.0F;            ///< [m]
  float inner = 0.0F;             ///< the ball of this radius about the centre lies within a shape [m]; 0: unknown
  int next = 0;                   ///< index of the first ball behind this subtree
};

/// A convex shape of a link, or a piece of something carried.
struct KernelBody {
  int frame = -1;      ///< −1: fixed
  int link = 0;        ///< index into KernelRobot::links
  int ball = 0;        ///< root of its subtree in KernelRobot::balls
  bool round = false;  ///< the shape is a ball: its own leaf decides exactly
};

/// All shapes of one link as one body.
struct KernelLink {
  int frame = -1;  ///< −1: fixed
  int ball = 0;    ///< root of its tree
  int first = 0;   ///< its bodies: indices into KernelRobot::bodies_of_links
  int count = 0;
};

struct KernelPair {
  int a = 0;  ///< index into KernelRobot::bodies
  int b = 0;
  float padding = 0.0F;  ///< distance to keep between the two [m]
};

/// Two links with pairs of bodies that must not touch.
struct KernelLinkPair {
  int a = 0;  ///< index into KernelRobot::links
  int b = 0;
  int first = 0;  ///< its pairs: range of KernelRobot::pairs
  int count = 0;
  float padding = 0.0F;  ///< the largest of its pairs [m]
  int between = 0;       ///< the first frame whose joint moves b and not a
  /// Link a carries link b by the joints between them, or is fixed: in a's frame only those joints move b.
  bool chain = false;
};

/// All planned arms as one robot.
struct KernelRobot {
  int dimensions = 0;
  std::vector<KernelFrame> frames;  ///< parents before children
  std::vector<KernelBody> bodies;   ///< in the order of the geometries' own bodies
  std::vector<KernelLink> links;
  std::vector<int> bodies_of_links;  ///< indices of bodies
  std::vector<int> body_of_ball;     ///< −1: the ball contains several bodies
  std::vector<KernelBall> balls;
  std::vector<KernelPair> pairs;  ///< pairs of bodies that must not touch, ordered by link pairs
  std::vector<KernelLinkPair> link_pairs;
  std::vector<int> order;  ///< the links that move, the most likely to collide first
  /// Row j: upper bounds of the motion of a link's points per unit of the joint of frame j [m/rad | 1], row by row of
  /// `link_stride`.
  std::vector<float> link_levers;
  /// The same for the motion of two links relative to each other, rows of `pair_stride`.
  std::vector<float> pair_levers;
  int link_stride = 0;
  int pair_stride = 0;
};

enum class ObstacleKind : std::uint8_t { kBall, kBox, kAlignedBox, kCapsule, kCylinder, kConvex, kPoints };

/// A core, and a ball that is swept along it. The core of points is all of them.
struct KernelObstacle {
  ObstacleKind kind = ObstacleKind::kBox;
  std::array<float, 9> axes{};    ///< unit axes, one after the other
  std::array<float, 3> centre{};  ///< [m]
  std::array<float, 3> along{};   ///< the centre along the axes [m]
  std::array<float, 3> half{};  ///< box: half extents; capsule: –, –, half length; cylinder: radius, –, half length [m]
  float radius = 0.0F;          ///< of the swept ball [m]
  int first = 0;                ///< convex: index into KernelWorld::planes
  int count = 0;
  const world::PointNode* nodes = nullptr;   ///< points: their tree, in the frame of `axes` and `along`; not owned
  const world::PointLeaf* leaves = nullptr;  ///< of that tree
};

/// Half space n · x ≤ offset.
struct KernelPlane {
  std::array<float, 3> normal{};
  float offset = 0.0F;  ///< [m]
};

/// Axis-aligned boxes of sixteen obstacles [m]. Unused places hold boxes that no link meets.
struct KernelBoxes {
  std::array<std::array<float, kTablePadding>, 3> low{};
  std::array<std::array<float, kTablePadding>, 3> high{};
  std::array<int, kTablePadding> obstacle{};
};

struct KernelWorld {
  float padding = 0.0F;  ///< distance to keep from all obstacles [m]
  std::vector<KernelObstacle> obstacles;
  std::vector<KernelPlane> planes;
  /// The obstacles that a link can come nearer to than padding + `margin`, for one link after the other.
  std::vector<KernelBoxes> boxes;
  std::vector<int> boxes_of_link;  ///< first index into `boxes` by link; one more at the end
  float margin = 0.0F;             ///< [m]
  std::vector<KernelBoxes> all;    ///< all obstacles
};

/// Lower bounds of the distance of two shapes, rounding included [m].
struct ExactGap {
  double at_start = 0.0;
  /// The same on the way to the second frame if all points moved straight.
  double on_way = 0.0;
};
/// Along the way of a pair of shapes from its place at one configuration to that at the next.
struct ExactQuestion {
  const float* from_a = nullptr;  ///< frames: four columns of x, y, z: the axes and the origin, in O
  const float* to_a = nullptr;    ///< null: there is no way
  const float* from_b = nullptr;  ///< null for an obstacle
  const float* to_b = nullptr;
  bool seen_from_a = false;      ///< points of b move straight in the frame of a, where a does not move
  double enough = 0.0;           ///< greater bounds on the way need not be exact [m]
  std::array<double, 3> axis{};  ///< a direction that parted the shapes before, tried first; the answer replaces it
};
/// Exact distances of shapes, for pairs that balls do not decide.
struct ExactCheck {
  const void* context = nullptr;
  ExactGap (*from_obstacle)(const void* context, int body, int obstacle, ExactQuestion& question) = nullptr;
  ExactGap (*from_body)(const void* context, int a, int b, ExactQuestion& question) = nullptr;
};

/// (1 − t)² a + 2 t (1 − t) corner + t² b, or the straight edge from a to b.
struct KernelEdge {
  const float* a = nullptr;
  const float* corner = nullptr;  ///< null: straight
  const float* b = nullptr;
  const float* spread = nullptr;  ///< by joint, all configurations within this distance as well [rad | m]; may be null
  float clearance = 0.0F;         ///< distance to keep from the world beyond the padding [m]
};

/// Storage of one caller, and what its last checks found. Results do not depend on it.
struct KernelMemory {
  std::vector<float> storage;  ///< at least ValidityKernel::floats_needed() floats
  std::uint32_t epoch = 0;     ///< of the present configurations
  std::uint32_t view = 0;      ///< of the present pair of links
  int hit_link = -1;           ///< link and obstacle that collided last: tried first
  int hit_obstacle = -1;
};

struct KernelScene {
  const KernelRobot& robot;
  const KernelWorld& world;
  ExactCheck exact;
  KernelMemory& memory;
};

struct ValidityKernel {
  int lanes;
  std::size_t (*floats_needed)(const KernelRobot&);
  /// Bit i: configuration i of kWidth collides. Configurations are `stride` floats apart.
  unsigned (*collisions)(const KernelScene&, const float* q, int stride);
  /// True if none of at least `steps` configurations, evenly spaced on the straight edge from a (excluded) to b
  /// (included), collides.
  bool (*edge_sampled)(const KernelScene&, const KernelEdge&, int steps);
  /// True if every configuration of the edge is free. False if one collides, or if that stays undecided.
  bool (*edge_proven)(const KernelScene&, const KernelEdge&);
};

/// The kernels that this processor can run, the narrowest first. Thread-safe.
[[nodiscard]] std::span<const ValidityKernel* const> supported_kernels();
/// The widest of them. Thread-safe.
[[nodiscard]] const ValidityKernel& fastest_validity();

namespace lanes4 {
extern const ValidityKernel kValidity;
}
namespace lanes8 {
extern const ValidityKernel kValidity;
}
namespace lanes16 {
extern const ValidityKernel kValidity;
}

}  // namespace hecaton::planner::global
