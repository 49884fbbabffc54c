#pragma once
/// How the page draws an arm: the visual elements of its URDF, and the mesh files that they name. Only these files are
/// served, and textures beside them.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/model/source_file.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services::view {

/// The URDF of an arm for the page.
struct ArmDrawing {
  std::string url;                           ///< "/robots/0.urdf"
  std::string urdf;                          ///< its text; mesh files have URLs of this server
  bool has_visuals = false;                  ///< false: the page draws the collision shapes
  std::string note;                          ///< a sentence about what cannot be drawn; empty: nothing
  std::vector<std::filesystem::path> files;  ///< its meshes, and the textures beside them that they name
};

class Drawings {
 public:
  /// Reads the URDFs. What cannot be read is left out with a note; never throws because of a file. `recorded`: a folder
  /// of copies, as a snapshot of planner::SourceFiles; it must outlive the object. Then no other mesh is read, and an
  /// arm without one of its meshes is drawn by its collision shapes.
  explicit Drawings(const config::CellFile& file, const std::filesystem::path& recorded = {});

  [[nodiscard]] const std::vector<ArmDrawing>& arms() const { return arms_; }  ///< one per arm of the cell
  /// The mesh or texture at a path of the server ("/meshes/3/hand.stl"); empty: there is none.
  [[nodiscard]] std::optional<std::filesystem::path> mesh(std::string_view path) const;
  /// The mesh that a URDF names so, "package://arm_description/meshes/hand.stl"; empty: there is none.
  [[nodiscard]] std::optional<std::filesystem::path> mesh_named(std::string_view uri) const;

 private:
  [[nodiscard]] ArmDrawing draw(const config::RobotFiles& robot, const planner::SourceFiles& sources);
  /// The file of a mesh. Throws planner::ModelError.
  [[nodiscard]] std::filesystem::path mesh_file(const std::string& uri, const config::RobotFiles& robot) const;
  [[nodiscard]] std::string mesh_url(const std::filesystem::path& file);

  std::filesystem::path recorded_;                     ///< empty: none
  std::vector<std::filesystem::path> recorded_files_;  ///< in it
  std::vector<ArmDrawing> arms_;
  std::vector<std::filesystem::path> meshes_;                        ///< by the number in their URL
  std::map<std::string, std::filesystem::path, std::less<>> named_;  ///< by the name in a URDF, which has a scheme
};

}  // namespace hecaton::services::view
