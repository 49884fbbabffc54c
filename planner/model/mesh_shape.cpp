#include "planner/model/mesh_shape.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <tinyxml2.h>

#include "planner/model/capsules.hpp"
#include "planner/model/collada_check.hpp"
#include "planner/model/convex_hull.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

Eigen::Matrix4d to_eigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  result << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return result;
}

/// Sums over triangles. The area vectors of a closed surface add up to zero.
struct Surface {
  double volume = 0.0;                             ///< of the tetrahedra from the origin [m³]
  double area = 0.0;                               ///< [m²]
  Eigen::Vector3d flux = Eigen::Vector3d::Zero();  ///< sum of the area vectors [m²]

  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d twice = (b - a).cross(c - a);
    volume += a.dot(b.cross(c)) / 6.0;
    area += 0.5 * twice.norm();
    flux += 0.5 * twice;
  }
  [[nodiscard]] std::optional<double> enclosed() const {
    constexpr double kClosed = 1e-6;
    if (flux.norm() > kClosed * area) return std::nullopt;
    return std::abs(volume);
  }
};

void append_triangles(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent,
                      const Eigen::Vector3d& scale, std::vector<Eigen::Vector3d>& vertices, Surface& surface) {
  const Eigen::Matrix4d X = parent * to_eigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    std::vector<Eigen::Vector3d> placed;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      placed.emplace_back((X * Eigen::Vector4d(p.x, p.y, p.z, 1.0)).head<3>().cwiseProduct(scale));
    }
    std::vector<bool> used(mesh.mNumVertices, false);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      const bool whole = face.mNumIndices >= 3 && std::all_of(face.mIndices, face.mIndices + face.mNumIndices,
                                                              [&](unsigned v) { return v < mesh.mNumVertices; });
      if (!whole) continue;
      for (unsigned k = 0; k < face.mNumIndices; ++k) used[face.mIndices[k]] = true;
      surface.add(placed[face.mIndices[0]], placed[face.mIndices[1]], placed[face.mIndices[2]]);
    }
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      if (used[v]) vertices.push_back(placed[v]);
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    append_triangles(scene, *node.mChildren[i], X, scale, vertices, surface);
  }
}

std::string lower_case_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool begins_as_lfs_pointer(const std::filesystem::path& place) {
  constexpr std::streamsize kEnough = 64;  // bytes
  std::string begin(kEnough, '\0');
  std::ifstream file(place, std::ios::binary);
  file.read(begin.data(), kEnough);
  return is_lfs_pointer(begin);
}

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;  ///< the corners of all triangles [m]
  std::optional<double> volume;           ///< [m³]; empty when the surface is not closed
};

Mesh load_mesh(const std::string& path, const Eigen::Vector3d& scale, const std::string& where, SourceFiles& sources) {
  const std::string mesh = where + ": mesh '" + path + "'";
  constexpr std::array kFormats{".stl", ".dae", ".obj"};
  const std::string extension = lower_case_extension(path);
  if (std::find(kFormats.begin(), kFormats.end(), extension) == kFormats.end()) {
    throw ModelError(mesh + " has ending '" + extension + "'; .stl, .dae and .obj are allowed");
  }
  std::error_code ignored;
  const std::filesystem::path place = sources.open(path);
  if (!std::filesystem::is_regular_file(place, ignored)) throw ModelError(mesh + " is no file that exists");
  if (begins_as_lfs_pointer(place)) throw ModelError(mesh + " " + kLfsPointer);

  if (extension == ".dae") {
    tinyxml2::XMLDocument document;
    try {
      load_xml(path, "Collada mesh", document, sources);
    } catch (const ModelError& error) {
      throw ModelError(mesh + " cannot be read: " + error.what());
    }
    if (document.RootElement() != nullptr) check_collada(*document.RootElement(), mesh);
  }
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(place.string(), aiProcess_Triangulate);
  if (scene == nullptr) {
    const std::string reason = importer.GetErrorString();
    throw ModelError(mesh + " cannot be read: " + reason.substr(0, reason.find('\n')));
  }

  Mesh result;
  Surface surface;
  if (scene->mRootNode != nullptr) {
    append_triangles(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), scale, result.vertices, surface);
  }
  if (result.vertices.empty()) throw ModelError(mesh + " has no triangles; a collision mesh needs some");
  constexpr double kFurthest = 100.0;  // [m]
  for (const Eigen::Vector3d& vertex : result.vertices) {
    if (!vertex.allFinite()) throw ModelError(mesh + " has a vertex that is not finite");
    if (vertex.cwiseAbs().maxCoeff() > kFurthest) {
      throw ModelError(mesh + " reaches further than 100 m; is scale=\"0.001 0.001 0.001\" missing?");
    }
  }
  result.volume = surface.enclosed();
  return result;
}

/// A mesh that fills this share of its hull is convex up to rounding.
constexpr double kConvex = 0.999;

std::string percent(double fraction) {
  return std::to_string(std::lround(100.0 * fraction)) + " %";
}

}  // namespace

MeshShape mesh_shape(const std::string& path, const Eigen::Vector3d& scale, MeshGeometry kind, const std::string& where,
                     SourceFiles& sources) {
  const Mesh mesh = load_mesh(path, scale, where, sources);
  const auto hull = convex_hull(mesh.vertices);
  if (!hull) throw ModelError(where + ": mesh '" + path + "' has no volume; a collision mesh must not be flat");

  MeshShape result;
  LinkGeometry& geometry = result.geometry;
  const double hull_volume = volume(*hull);
  // Rounding can make the hull of a convex mesh the smaller one.
  const double mesh_volume = std::min(mesh.volume.value_or(hull_volume), hull_volume);
  const std::string of_what = mesh.volume ? "the mesh" : "its hull, for the mesh is not closed";
  const auto stands_for = [&](const std::string& what, double shape_volume) {
    geometry.excess_volume = shape_volume / mesh_volume - 1.0;
    result.note = where + ": " + what + " stands for mesh '" + path + "', " + percent(geometry.excess_volume) +
                  " larger than " + of_what;
  };
  if (kind == MeshGeometry::kCapsule) {
    const PlacedCapsule placed = enclosing_capsule(hull->vertices);
    geometry.shape = placed.capsule;
    geometry.X_LS = placed.X_FS;
    stands_for("an enclosing capsule", volume(placed.capsule));
    return result;
  }
  auto outer = std::make_shared<world::ConvexHull>(enclosing_hull(*hull, kMaxHullVertices));
  if (outer->vertices.size() != hull->vertices.size()) {
    stands_for("an enclosing polyhedron of " + std::to_string(outer->vertices.size()) + " vertices", volume(*outer));
  } else if (mesh_volume < kConvex * hull_volume) {
    stands_for("the convex hull", hull_volume);
  }
  geometry.shape = world::Convex{std::move(outer)};
  return result;
}

}  // namespace hecaton::planner
