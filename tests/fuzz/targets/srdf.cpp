// An SRDF beside the URDF of a PUMA 560.

#include "planner/model/srdf.hpp"

#include <vector>

#include "planner/model/urdf_loader.hpp"
#include "services/config/moveit_files.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

template <class Read>
void read_srdf(const Read& function) {
  try {
    function();
  } catch (const hecaton::planner::ModelError& error) {
    hecaton::fuzz::require_sentence(error.what());
  }
}

std::vector<hecaton::planner::TreeLink> tree_of(const hecaton::planner::RobotModel& model) {
  std::vector<hecaton::planner::TreeLink> tree;
  for (const hecaton::planner::Link& link : model.links) tree.emplace_back().link = link;
  return tree;
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(srdf)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  static const auto kPuma = planner::load_urdf(fuzz::source("deploy/cells/urdf/puma560.urdf"));
  const std::string path = fuzz::folder().write("robot.srdf", fuzz::text_of({data, size}));
  read_srdf([&] {
    planner::SourceFiles sources;
    planner::RobotModel model = *kPuma;
    planner::apply_srdf(path, {"left_out"}, model, sources);
    for (const auto& [name, q] : model.named) {
      const bool inside = q.size() == model.joints() && (q.array() >= model.limits.lower.array() - 1e-3).all() &&
                          (q.array() <= model.limits.upper.array() + 1e-3).all();
      fuzz::require(inside, "a named configuration sets every joint within its limits");
    }
  });
  read_srdf([&] {
    planner::SourceFiles sources;
    static_cast<void>(planner::srdf_tool_link(path, tree_of(*kPuma), "", sources));
    static_cast<void>(planner::srdf_tool_link(path, tree_of(*kPuma), "base_link", sources));
  });
  read_srdf([&] { static_cast<void>(config::groups_of_srdf(path)); });
  return 0;
}
