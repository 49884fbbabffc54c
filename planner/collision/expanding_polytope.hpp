#pragma once
/// The shortest translation that separates two convex bodies, by the expanding polytope algorithm [VanDenBergen01]. It
/// uses the support function of their Minkowski difference, and storage of fixed size on the stack.
///
/// FCL's EPA uses each face's distance from the origin instead of that of the face's plane. This breaks the polytope
/// when the origin projects outside a face (docs/explanation/0002-distances.md). Here every face keeps its plane with a
/// sign, so that bodies that touch or are slightly apart are no special case.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>

namespace hecaton::planner {

struct LeastDepth {
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();            ///< unit, outward
  double depth = std::numeric_limits<double>::infinity();  ///< max n·x over the difference [m]: never below the least
  double at_least = -std::numeric_limits<double>::infinity();  ///< lower bound for all directions [m]
};

/// An inner approximation of a convex set by the convex hull of some of its points.
class ExpandingPolytope {
 public:
  static constexpr int kVertices = 96;
  static constexpr double kTolerance = 1e-9;  ///< the search ends when `depth − at_least` is smaller [m]

  /// `support(n)`: a point of the set that is farthest along unit n. The set must have a volume.
  template <typename Support>
  LeastDepth least_depth(const Support& support) {
    LeastDepth best;
    const auto probe = [&](const Eigen::Vector3d& n) -> Eigen::Vector3d {
      Eigen::Vector3d w = support(n);
      if (const double depth = n.dot(w); depth < best.depth) {
        best.n = n;
        best.depth = depth;
      }
      return w;
    };
    if (!start(probe)) return best;
    while (true) {
      const Face face = nearest_face();
      best.at_least = face.offset;
      if (best.depth - face.offset <= kTolerance) return best;
      const Eigen::Vector3d w = probe(face.n);
      if (best.depth - face.offset <= kTolerance || !add(w)) return best;
    }
  }

 private:
  static constexpr int kFaces = 2 * kVertices;  // a closed triangulated surface of V vertices has 2V − 4
  static constexpr int kEdges = 3 * kVertices;
  static constexpr double kCoplanar = 1e-13;  // [m]

  struct Face {
    std::array<std::int16_t, 3> vertex{};
    Eigen::Vector3d n = Eigen::Vector3d::Zero();  // unit, outward
    double offset = 0.0;                          // of its plane from the origin along n [m]; < 0: origin is outside
  };
  struct Edge {
    std::int16_t from;
    std::int16_t to;
  };

  /// Begins with a tetrahedron. False when the set seems to have no volume.
  template <typename Probe>
  bool start(const Probe& probe) {
    vertex_count_ = 0;
    face_count_ = 0;
    Eigen::Vector3d longest = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d high = probe(Eigen::Vector3d::Unit(axis));
      const Eigen::Vector3d low = probe(-Eigen::Vector3d::Unit(axis));
      if ((high - low).squaredNorm() <= longest.squaredNorm()) continue;
      longest = high - low;
      vertices_[0] = low;
      vertices_[1] = high;
    }
    if (longest.squaredNorm() < 1e-18) return false;
    const auto farthest_along = [&](const Eigen::Vector3d& n) -> Eigen::Vector3d {
      const Eigen::Vector3d high = probe(n);
      const Eigen::Vector3d low = probe(-n);
      const double middle = n.dot(vertices_[0]);
      return n.dot(high) - middle >= middle - n.dot(low) ? high : low;
    };
    const Eigen::Vector3d across = longest.unitOrthogonal();
    vertices_[2] = farthest_along(across);
    Eigen::Vector3d n = longest.cross(vertices_[2] - vertices_[0]);
    if (n.norm() < 1e-9 * longest.norm()) {
      vertices_[2] = farthest_along(longest.cross(across).normalized());
      n = longest.cross(vertices_[2] - vertices_[0]);
    }
    if (n.norm() < 1e-9 * longest.norm()) return false;
    n.normalize();
    vertices_[3] = farthest_along(n);
    const double height = n.dot(vertices_[3] - vertices_[0]);
    if (std::abs(height) < 1e-9) return false;
    if (height > 0.0) std::swap(vertices_[0], vertices_[1]);  // now 0, 1, 2 is counter-clockwise seen from outside
    vertex_count_ = 4;
    return push(0, 1, 2) && push(1, 0, 3) && push(2, 1, 3) && push(0, 2, 3);
  }

  [[nodiscard]] const Face& nearest_face() const {
    int nearest = 0;
    for (int i = 1; i < face_count_; ++i) {
      if (faces_[i].offset < faces_[nearest].offset) nearest = i;
    }
    return faces_[nearest];
  }

  bool push(int a, int b, int c) {
    if (face_count_ == kFaces) return false;
    Face& face = faces_[face_count_];
    face.vertex = {static_cast<std::int16_t>(a), static_cast<std::int16_t>(b), static_cast<std::int16_t>(c)};
    const Eigen::Vector3d ab = vertices_[b] - vertices_[a];
    const Eigen::Vector3d ac = vertices_[c] - vertices_[a];
    face.n = ab.cross(ac);
    const double area = face.n.norm();
    if (area > 1e-11 * ab.norm() * ac.norm()) {
      face.n /= area;
      face.offset = face.n.dot(vertices_[a]);
    } else if (!inherit_plane(face)) {
      return false;
    }
    ++face_count_;
    return true;
  }

  /// A new vertex in line with an edge of the horizon gives a face without area. It takes the plane beyond that edge.
  bool inherit_plane(Face& sliver) const {
    for (int i = 0; i < face_count_; ++i) {
      for (int e = 0; e < 3; ++e) {
        if (faces_[i].vertex[e] != sliver.vertex[1] || faces_[i].vertex[(e + 1) % 3] != sliver.vertex[0]) continue;
        sliver.n = faces_[i].n;
        sliver.offset = faces_[i].offset;
        return true;
      }
    }
    return false;
  }

  /// Replaces all faces visible from w by faces from their outline to w. False when w adds nothing or storage is full.
  bool add(const Eigen::Vector3d& w) {
    if (vertex_count_ == kVertices) return false;
    edge_count_ = 0;
    int kept = 0;
    for (int i = 0; i < face_count_; ++i) {
      const Face face = faces_[i];
      if (face.n.dot(w) - face.offset <= kCoplanar) {
        faces_[kept++] = face;
        continue;
      }
      for (int e = 0; e < 3; ++e) {
        if (!toggle(face.vertex[e], face.vertex[(e + 1) % 3])) return false;
      }
    }
    if (kept == face_count_) return false;
    face_count_ = kept;
    vertices_[vertex_count_] = w;
    for (int e = 0; e < edge_count_; ++e) {
      if (!push(edges_[e].from, edges_[e].to, vertex_count_)) return false;
    }
    ++vertex_count_;
    return face_count_ > 0;
  }

  /// An edge between two visible faces occurs twice, once each way, and cancels; the outline remains.
  bool toggle(std::int16_t from, std::int16_t to) {
    for (int e = 0; e < edge_count_; ++e) {
      if (edges_[e].from != to || edges_[e].to != from) continue;
      edges_[e] = edges_[--edge_count_];
      return true;
    }
    if (edge_count_ == kEdges) return false;
    edges_[edge_count_++] = {from, to};
    return true;
  }

  std::array<Eigen::Vector3d, kVertices> vertices_;
  std::array<Face, kFaces> faces_;
  std::array<Edge, kEdges> edges_;
  int vertex_count_ = 0;
  int face_count_ = 0;
  int edge_count_ = 0;
};

}  // namespace hecaton::planner
