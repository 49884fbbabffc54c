// The world service: edits reach all nodes or are refused with a sentence.
#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

class MotionWorld : public MotionCell {
 protected:
  MotionWorld()
      : MotionCell(1,
                   "  - name: post\n"
                   "    shapes: [{type: box, size: [0.1, 0.1, 0.1]}]\n"
                   "    pose: {xyz: [1.5, 0, 0.5]}\n") {}

  [[nodiscard]] const msg::ObstacleShapes* obstacle(const std::string& name) {
    const auto* sample = shapes_.latest(name);
    return sample == nullptr ? nullptr : &sample->value;
  }
  static msg::WorldEditRequest request(msg::EditKind kind, const std::string& name, const std::string& arm = "") {
    msg::WorldEditRequest message;
    message.kind(kind);
    message.name(name);
    message.arm(arm);
    message.X_WO().qw(1.0);
    return message;
  }
  [[nodiscard]] std::string refusal(const msg::WorldEditRequest& wanted) {
    const auto reply = edit(wanted);
    EXPECT_FALSE(reply.done());
    return reply.cause().text();
  }

  /// The world's reply to `attach` after the arm's state has reached the world, which refuses before.
  [[nodiscard]] msg::WorldEditReply attach(const std::string& name, const std::string& arm) {
    msg::WorldEditReply reply;
    EXPECT_TRUE(await([&] {
      reply = edit(request(msg::EditKind::EDIT_ATTACH, name, arm));
      return reply.done() || reply.cause().text().find("has not reported its position") == std::string::npos;
    })) << reply.cause().text();
    return reply;
  }
};

TEST_F(MotionWorld, PublishesItsObstaclesToLateJoiners) {
  start_world();
  ASSERT_TRUE(await([&] { return obstacle("post") != nullptr; }));
  EXPECT_EQ(obstacle("post")->obstacle().shapes()[0].dimensions().x(), 0.05);
  bus::Reader<msg::ObstacleShapes> late(participant_, &mailbox_);
  EXPECT_TRUE(await([&] { return late.latest("post") != nullptr; }));
}

TEST_F(MotionWorld, PublishesEditsInShapesAndStates) {
  bus::Reader<msg::ObstacleStates> states(participant_, &mailbox_);
  const auto state = [&](const std::string& name) -> const msg::ObstacleState* {
    const auto& newest = states.latest();
    if (newest.empty()) return nullptr;
    for (const auto& candidate : newest.begin()->second.value.states()) {
      if (candidate.name() == name) return &candidate;
    }
    return nullptr;
  };
  start_world();
  start_driver();
  ASSERT_TRUE(await([&] { return obstacle("post") != nullptr && arm() != nullptr; }));

  msg::WorldEditRequest add = request(msg::EditKind::EDIT_ADD, "");
  add.obstacle(box("crate", 2.0, 0.5, 0.5));
  const auto added = edit(add);
  ASSERT_TRUE(added.done()) << added.cause().text();
  ASSERT_TRUE(await([&] { return obstacle("crate") != nullptr && state("crate") != nullptr; }));

  msg::WorldEditRequest move = request(msg::EditKind::EDIT_MOVE, "crate");
  move.X_WO().position().x(1.25);
  ASSERT_TRUE(edit(move).done());
  ASSERT_TRUE(await([&] { return state("crate") != nullptr && state("crate")->X_WO().position().x() == 1.25; }));

  const auto out_of_reach = attach("crate", "arm1");
  EXPECT_FALSE(out_of_reach.done());
  EXPECT_NE(out_of_reach.cause().text().find("at most 0.1 m from the tool"), std::string::npos)
      << out_of_reach.cause().text();

  // At home the tool is at (0.2194, 0.15, 1.4507) and points along (0.964, 0, 0.267) [m]: 0.1 m ahead of it.
  move.X_WO().position().x(0.3158);
  move.X_WO().position().y(0.15);
  move.X_WO().position().z(1.4775);
  ASSERT_TRUE(edit(move).done());

  const auto attached = attach("crate", "arm1");
  ASSERT_TRUE(attached.done()) << attached.cause().text();
  ASSERT_TRUE(await([&] { return obstacle("crate")->obstacle().attached_to() == "arm1"; }));
  ASSERT_TRUE(await([&] { return arm()->carried() == "crate"; }));
  EXPECT_NE(refusal(request(msg::EditKind::EDIT_DETACH, "crate", "arm2")).find("attached to 'arm1'"),
            std::string::npos);
  ASSERT_TRUE(edit(request(msg::EditKind::EDIT_DETACH, "crate")).done());
  ASSERT_TRUE(await([&] { return obstacle("crate")->obstacle().attached_to().empty() && arm()->carried().empty(); }));

  const auto removed = edit(request(msg::EditKind::EDIT_REMOVE, "crate"));
  ASSERT_TRUE(removed.done());
  EXPECT_GT(removed.edition(), added.edition());
  ASSERT_TRUE(await([&] { return obstacle("crate") == nullptr && state("crate") == nullptr; }));
  EXPECT_NE(obstacle("post"), nullptr);
}

TEST_F(MotionWorld, RefusesEditsWithASentenceAndWithoutAChange) {
  start_world();
  ASSERT_TRUE(await([&] { return obstacle("post") != nullptr; }));
  const auto edition = obstacle("post")->edition();
  msg::WorldEditRequest again = request(msg::EditKind::EDIT_ADD, "");
  again.obstacle(box("post", 2.0, 0.5, 0.5));
  EXPECT_NE(refusal(again).find("post"), std::string::npos);
  again.obstacle(box("arm1", 2.0, 0.5, 0.5));
  EXPECT_NE(refusal(again).find("an arm has the same name"), std::string::npos);
  again.obstacle(box("two words", 2.0, 0.5, 0.5));
  EXPECT_NE(refusal(again).find("a to z, A to Z"), std::string::npos);
  again.obstacle(box("flat", 2.0, 0.5, 0.5));
  again.obstacle().shapes()[0].dimensions().z(0.0);
  EXPECT_NE(refusal(again).find("flat"), std::string::npos);
  EXPECT_NE(refusal(request(msg::EditKind::EDIT_REMOVE, "ghost")).find("ghost"), std::string::npos);
  EXPECT_NE(refusal(request(msg::EditKind::EDIT_ATTACH, "post", "arm9")).find("arm9"), std::string::npos);
  EXPECT_NE(refusal(request(msg::EditKind::EDIT_DETACH, "post")).find("post"), std::string::npos);
  start_driver();
  ASSERT_TRUE(await([&] { return arm() != nullptr; }));
  // At home the tool is at (0.2194, 0.15, 1.4507) [m]; once the world knows the arm's state, it refuses obstacles
  // there.
  again.obstacle(box("hat", 0.2194, 0.15, 1.4507));
  msg::WorldEditReply reply;
  ASSERT_TRUE(await([&] {
    reply = edit(again);
    if (reply.done()) static_cast<void>(edit(request(msg::EditKind::EDIT_REMOVE, "hat")));
    return !reply.done();
  }));
  EXPECT_NE(reply.cause().text().find("must be clear of the arms, but arm1/"), std::string::npos)
      << reply.cause().text();
  ASSERT_TRUE(await([&] { return obstacle("hat") == nullptr; }));
  EXPECT_EQ(obstacle("post")->edition(), edition);
  EXPECT_EQ(shapes_.latest().size(), 1U);
}

}  // namespace
}  // namespace hecaton::test
