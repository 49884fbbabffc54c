// Three arms above a table with a box on it, and beside a post, all of which a depth camera has seen: points.
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton {
namespace {

constexpr double kSpacing = 0.01;  // [m]

/// The sides of a box but for its bottom.
void write_box(std::ofstream& file, const Eigen::Vector3d& centre, const Eigen::Vector3d& half) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      if (axis == 2 && side < 0.0) continue;
      for (double a = -half[u]; a <= half[u]; a += kSpacing) {
        for (double b = -half[v]; b <= half[v]; b += kSpacing) {
          Eigen::Vector3d p = centre;
          p[axis] += side * half[axis];
          p[u] += a;
          p[v] += b;
          file << p.transpose() << "\n";
        }
      }
    }
  }
}

void write_post(std::ofstream& file, const Eigen::Vector3d& foot, double radius, double height) {
  const int around = static_cast<int>(2.0 * std::numbers::pi * radius / kSpacing);
  for (double z = 0.0; z <= height; z += kSpacing) {
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / around;
      file << (foot + Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z)).transpose() << "\n";
    }
  }
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, old.size(), by);
}

/// The cell three_puma with other obstacles.
config::CellFile scanned_cell(const std::filesystem::path& folder) {
  {
    std::ofstream cloud(folder / "scan.xyz");
    write_box(cloud, {0.0, 0.0, 0.35}, {0.3, 0.3, 0.05});     // a table
    write_box(cloud, {0.05, 0.0, 0.45}, {0.08, 0.08, 0.05});  // a box on it
    write_post(cloud, {0.325, -0.563, 0.0}, 0.05, 1.2);
  }
  std::ifstream original(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml");
  std::string text{std::istreambuf_iterator<char>(original), {}};
  text = replaced(text, "urdf: urdf", "urdf: " + std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf");
  text.resize(text.find("obstacles:"));
  text += "obstacles:\n  - {name: scan, shapes: [{type: points, file: scan.xyz, radius: 0.01}]}\n";
  std::ofstream(folder / "scanned.yaml") << text;
  return config::load_cell_file((folder / "scanned.yaml").string());
}

TEST(ScannedCell, ArmsReachTheirGoalsWithoutContact) {
  const test::TemporaryFolder folder;
  const config::CellFile file = scanned_cell(folder.path());
  for (const config::Finding& finding : config::validate(file)) {
    EXPECT_NE(finding.severity, config::Severity::kError) << finding.sentence;
  }
  const auto& shape = file.cell.scene.obstacles[0].shapes[0].shape;
  EXPECT_GT(std::get<world::Points>(shape).cloud->size(), 8000U);
  planner::BatchOptions options;
  options.tasks = 24;
  options.seed = 1;
  const planner::BatchReport report = planner::simulate_tasks(file.cell, options);
  EXPECT_EQ(report.failure, std::nullopt);
  EXPECT_EQ(report.tasks, options.tasks);
  EXPECT_EQ(report.contacts, 0U);
  EXPECT_GE(report.reached, report.tasks - 2);
  ASSERT_TRUE(report.has_smallest);
  RecordProperty("smallest_mm", static_cast<int>(1e3 * report.smallest.distance));
}

}  // namespace
}  // namespace hecaton
