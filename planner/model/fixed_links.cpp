#include "planner/model/fixed_links.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace hecaton::planner {
namespace {

/// Children, geometry and the tool's index refer to the parent of link `removed` afterwards.
void merge_into_parent(int removed, RobotModel& model) {
  const int parent = model.links[removed].parent;
  const Pose X_PL = model.links[removed].X_PJ;
  for (Link& link : model.links) {
    if (link.parent == removed) {
      link.parent = parent;
      link.X_PJ = X_PL * link.X_PJ;
    }
    if (link.parent > removed) --link.parent;
  }
  for (LinkGeometry& geometry : model.geometry) {
    if (geometry.link == removed) {
      geometry.link = parent;
      geometry.X_LS = X_PL * geometry.X_LS;
    }
    if (geometry.link > removed) --geometry.link;
  }
  if (model.tool_link > removed) --model.tool_link;
  model.links.erase(model.links.begin() + removed);
}

/// Restores the order of RobotModel::geometry.
void sort_geometry(RobotModel& model) {
  const int shapes = static_cast<int>(model.geometry.size());
  std::vector<int> order(shapes);  // the old index of each new one
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return model.geometry[a].link < model.geometry[b].link; });
  std::vector<LinkGeometry> sorted;
  std::vector<int> place(shapes);
  for (int i = 0; i < shapes; ++i) {
    sorted.push_back(model.geometry[order[i]]);
    place[order[i]] = i;
  }
  model.geometry = std::move(sorted);
  for (auto& pair : model.self_pairs) {
    const int a = place[pair.first];
    const int b = place[pair.second];
    pair = {std::min(a, b), std::max(a, b)};
  }
  std::sort(model.self_pairs.begin(), model.self_pairs.end());
}

bool has_geometry(const RobotModel& model, int link) {
  return std::any_of(model.geometry.begin(), model.geometry.end(),
                     [&](const LinkGeometry& geometry) { return geometry.link == link; });
}

}  // namespace

void merge_fixed_links(int most, RobotModel& model) {
  const std::size_t before = model.links.size();
  const auto is_on_way = [&](int link) {
    int i = model.tool_link;
    while (i > link) i = model.links[i].parent;
    return i == link;
  };
  const auto merge = [&](auto&& may_go) {
    for (int i = static_cast<int>(model.links.size()) - 1; i > 0; --i) {
      if (static_cast<int>(model.links.size()) <= most) return;
      if (model.links[i].joint < 0 && i != model.tool_link && may_go(i)) merge_into_parent(i, model);
    }
  };
  merge([&](int i) { return !is_on_way(i) && !has_geometry(model, i); });
  merge([&](int i) { return !is_on_way(i); });
  merge([](int /*i*/) { return true; });
  if (model.links.size() == before) return;
  sort_geometry(model);
  model.notes.push_back("the robot has " + std::to_string(before) + " links; " +
                        std::to_string(before - model.links.size()) +
                        " of them that are fixed to others are merged with those");
}

}  // namespace hecaton::planner
