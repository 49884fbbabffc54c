#include "services/world/world_edit.hpp"

#include "services/bus/convert.hpp"

namespace hecaton::services {

const std::string& edited_name(const msg::WorldEditRequest& request) {
  return request.kind() == msg::EDIT_ADD ? request.obstacle().name() : request.name();
}

world::EditResult apply_edit(world::BulletWorld& world, const msg::WorldEditRequest& request) {
  switch (request.kind()) {
    case msg::EDIT_ADD: {
      const auto obstacle = bus::from_message(request.obstacle());
      return obstacle ? world.add(*obstacle) : world::EditResult{false, obstacle.error};
    }
    case msg::EDIT_MOVE: {
      const auto X_WO = bus::from_message(request.X_WO(), "obstacle \"" + request.name() + "\": X_WO");
      return X_WO ? world.move(request.name(), *X_WO) : world::EditResult{false, X_WO.error};
    }
    case msg::EDIT_REMOVE:
      return world.remove(request.name());
    case msg::EDIT_ATTACH:
      return world.attach(request.name(), request.arm());
    case msg::EDIT_DETACH:
      return world.detach(request.name());
  }
  return {false, "edit: unknown kind"};
}

}  // namespace hecaton::services
