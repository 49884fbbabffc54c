#include "services/view/orders.hpp"

#include <gtest/gtest.h>

#include "tests/support/free_domain.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using view::Json;

const std::string kOrderedCell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";

/// Orders to a domain without a cell: what the server decides before it sends anything.
class OrdersTest : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Orders> orders(OrderOptions options) {
    return std::make_unique<Orders>(file_, std::move(options),
                                    client::Connection::make(client::join(file_, domain_.number())));
  }
  /// The only reply to this message, at once.
  [[nodiscard]] Json reply_to(const WebClient& page, const Json& message) {
    orders_->received(page, message.dump(), now_);
    const Orders::Replies replies = orders_->take_replies();
    if (replies.size() != 1 || replies.front().first != page.number) return nullptr;
    return replies.front().second;
  }
  [[nodiscard]] Json take(const WebClient& page, const std::string& token) {
    return reply_to(page, {{"id", 1}, {"op", "take"}, {"token", token}});
  }
  [[nodiscard]] std::string controller() {
    orders_->announce_control();
    const Json control = *orders_->take_control_change();
    return control.at("controller").is_null() ? "none" : control.at("controller").at("address").get<std::string>();
  }

  config::CellFile file_ = config::load_cell_file(kOrderedCell);
  test::FreeDomain domain_;
  const std::string token_ = random_token();
  const WebClient first_{1, "127.0.0.1:1001"};
  const WebClient second_{2, "127.0.0.1:1002"};
  Orders::Clock::time_point now_ = Orders::Clock::now();
  std::unique_ptr<Orders> orders_ = orders({true, token_, {}});
};

TEST(Token, IsLongAndRandomAndComparedAsAWhole) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 64U);
  EXPECT_NE(token, random_token());
  EXPECT_TRUE(same_token(token, std::string(token)));
  EXPECT_FALSE(same_token(token, token.substr(1)));
  EXPECT_FALSE(same_token(token, ""));
  std::string other = token;
  other.back() = other.back() == '0' ? '1' : '0';
  EXPECT_FALSE(same_token(token, other));
}

TEST_F(OrdersTest, RefuseAllButStopFromAPageWithoutControl) {
  for (const char* op :
       {"hold", "resume", "goal", "cancel", "obstacle_add", "obstacle_move", "obstacle_remove", "save"}) {
    const Json reply = reply_to(first_, {{"id", 5}, {"op", op}});
    EXPECT_EQ(reply.at("text"), "this page does not control the cell") << op;
    EXPECT_EQ(reply.at("id"), 5);
    EXPECT_FALSE(reply.at("done"));
  }
  const Json arm = reply_to(first_, {{"id", 6}, {"op", "stop"}, {"arms", {"north"}}});
  EXPECT_EQ(arm.at("text"), "this page does not control the cell");
}

TEST_F(OrdersTest, GiveControlToOnePageWithTheToken) {
  EXPECT_FALSE(take(first_, random_token()).at("done"));
  EXPECT_EQ(controller(), "none");
  const Json taken = take(first_, token_);
  EXPECT_TRUE(taken.at("done"));
  EXPECT_EQ(taken.at("number"), 1);
  EXPECT_EQ(controller(), first_.address);
  EXPECT_NE(take(second_, token_).at("text").get<std::string>().find(first_.address), std::string::npos);
  EXPECT_EQ(controller(), first_.address);
  EXPECT_TRUE(reply_to(first_, {{"id", 2}, {"op", "release"}}).at("done"));
  EXPECT_TRUE(take(second_, token_).at("done"));
  orders_->left(second_);
  EXPECT_EQ(controller(), "none");
  EXPECT_TRUE(take(first_, token_).at("done"));
}

TEST_F(OrdersTest, RefuseOnlyTheResumeOfAProgramWhileAPageControls) {
  const WebClient program{3, "127.0.0.1:1003"};
  const std::string refusal = "the page at " + first_.address + " controls the cell, until it releases it or is closed";
  std::string resume;
  std::string hold;
  EXPECT_TRUE(take(first_, token_).at("done"));
  orders_->give(
      program, client::ModeOrder::kResume, {}, [&](bool, const std::string& text) { resume = text; }, now_);
  orders_->give(
      program, client::ModeOrder::kHold, {}, [&](bool, const std::string& text) { hold = text; }, now_);
  orders_.reset();  // waits for the answers
  EXPECT_EQ(resume, refusal);
  EXPECT_NE(hold, refusal) << "a program may always make arms stand";
}

TEST_F(OrdersTest, EndTheControlOfASilentPage) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  now_ += kControlLease;
  orders_->received(first_, R"({"op": "alive"})", now_);
  now_ += kControlLease;
  orders_->update(now_);
  EXPECT_EQ(controller(), first_.address);
  orders_->received(second_, R"({"op": "alive"})", now_ + 1s);
  orders_->update(now_ + 1s);
  EXPECT_EQ(controller(), "none");
}

TEST_F(OrdersTest, RefuseControlWithoutTheOption) {
  orders_ = orders({true, "", {}});
  EXPECT_NE(take(first_, "").at("text").get<std::string>().find("--control"), std::string::npos);
  EXPECT_EQ(controller(), "none");
}

TEST_F(OrdersTest, RefuseStopWithTheOptionUnlessThePageControls) {
  orders_ = orders({false, token_, {}});
  EXPECT_NE(reply_to(first_, {{"id", 1}, {"op", "stop"}}).at("text").get<std::string>().find("--no-stop"),
            std::string::npos);
  EXPECT_TRUE(take(first_, token_).at("done"));
  orders_->received(first_, R"({"id": 2, "op": "stop"})", now_);
  EXPECT_TRUE(orders_->take_replies().empty()) << "it waits for a cell";
}

TEST_F(OrdersTest, SayWhatIdentityIsMissing) {
  orders_ = std::make_unique<Orders>(file_, OrderOptions{true, token_, "no identity of the role operator"}, nullptr);
  EXPECT_EQ(take(first_, token_).at("text"), "no identity of the role operator");
  EXPECT_EQ(reply_to(first_, {{"id", 1}, {"op", "stop"}}).at("text"), "no identity of the role operator");
  EXPECT_FALSE(orders_->take_control_change()->at("stop"));
}

TEST_F(OrdersTest, LimitTheOrdersOfEachPageButNotTheStop) {
  int limited = 0;
  for (int i = 0; i < 40; ++i) {
    limited += reply_to(first_, {{"id", i}, {"op", "hold"}}).at("text") == "this page sends too many orders" ? 1 : 0;
  }
  EXPECT_EQ(limited, 20);
  EXPECT_EQ(reply_to(second_, {{"id", 1}, {"op", "hold"}}).at("text"), "this page does not control the cell");
  EXPECT_TRUE(reply_to(first_, {{"id", 2}, {"op", "stop"}}).is_null()) << "a stop waits for a cell, and is not refused";
  now_ += 1s;
  EXPECT_EQ(reply_to(first_, {{"id", 3}, {"op", "hold"}}).at("text"), "this page does not control the cell");
}

TEST_F(OrdersTest, RefuseMalformedOrdersWithASentence) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  orders_->received(first_, "{", now_);
  orders_->received(first_, "[1]", now_);
  orders_->received(first_, std::string(4000, '['), now_);
  EXPECT_TRUE(orders_->take_replies().empty()) << "no order has an answer without an object";
  const auto text = [&](const Json& message) { return reply_to(first_, message).at("text").get<std::string>(); };
  EXPECT_EQ(text({{"op", 3}}), "the order needs 'op', a text of at most 128 bytes");
  EXPECT_EQ(text({{"op", "jump"}}), "'jump' is no order that a page can give");
  EXPECT_EQ(text({{"op", "hold"}, {"arms", {"south"}}}), "'south' is no arm of the cell");
  EXPECT_EQ(text({{"op", "stop"}, {"arms", 3}}), "'arms' must be a list of arms; without it the order is for the cell");
  EXPECT_EQ(text({{"op", "goal"}, {"arm", "north"}, {"named", "up\n"}}), "arm 'north' has no pose 'up\\x0a'");
  EXPECT_EQ(text({{"op", "obstacle_move"}, {"name", "crate"}, {"pose", {1, 2, 3, 0, 0, 0, 0}}}),
            "the rotation of 'pose' must be a unit quaternion");
  EXPECT_EQ(text({{"op", "obstacle_move"}, {"name", "crate"}, {"pose", {1, 2, nullptr, 0, 0, 0, 1}}}),
            "the order needs 'pose', a list of 7 numbers");
  EXPECT_EQ(text({{"op", "obstacle_remove"}, {"name", std::string(200, 'a')}}),
            "the order needs 'name', a text of at most 128 bytes");
  EXPECT_EQ(text({{"op", "goal"}, {"arm", "north"}, {"q", {0, 1, 2}}}), "the order needs 'q', a list of 6 numbers");
  EXPECT_EQ(text({{"op", "goal"}, {"arm", "north"}, {"q", {0, 1, 2, 3, 4, nullptr}}}),
            "the order needs 'q', a list of 6 numbers");
}

// A stalled network delivers what it kept, seconds after a person has ordered it.
TEST_F(OrdersTest, RefuseWhatMovesArmsWhenItArrivesLate) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  now_ = orders_->began() + 60s;
  const auto reply = [&](std::int64_t seen, const Json& order) {
    Json message = order;
    message["seen"] = seen;
    return reply_to(first_, message);
  };
  const std::vector<Json> moving = {{{"op", "resume"}},
                                    {{"op", "resume"}, {"arms", {"north"}}},
                                    {{"op", "goal"}, {"arm", "north"}, {"named", "ready"}},
                                    {{"op", "obstacle_remove"}, {"name", "crate"}}};
  for (const Json& order : moving) {
    const Json late = reply(57'999, order);
    ASSERT_FALSE(late.is_null()) << order;
    EXPECT_EQ(
        late.at("text"),
        "the order came 2.0 s after the state that its page showed (limit 2 s): look at the cell, and order again");
    EXPECT_FALSE(late.at("done"));
  }
  const Json removal{{"op", "obstacle_remove"}, {"name", "crate"}};
  EXPECT_TRUE(reply(58'000, removal).is_null()) << "it waits for a cell, and is not refused";
  EXPECT_TRUE(reply(60'000, removal).is_null());
  EXPECT_FALSE(reply(62'001, removal).is_null()) << "no state has been sent yet at that time";
  Json text = removal;
  text["seen"] = "60000";
  EXPECT_EQ(reply_to(first_, text).at("text"), "the order needs 'seen', a number of milliseconds");
}

TEST_F(OrdersTest, CarryOutAHoldAndAStopThatArriveLate) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  now_ = orders_->began() + 60s;
  for (const char* op : {"hold", "stop"}) {
    EXPECT_TRUE(reply_to(first_, {{"op", op}, {"seen", 0}}).is_null()) << "it waits for a cell, and is not refused";
    EXPECT_TRUE(reply_to(first_, {{"op", op}, {"arms", {"north"}}, {"seen", 0}}).is_null());
  }
}

TEST_F(OrdersTest, CarryOutOrdersOfProgramsThatNameNoState) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  now_ = orders_->began() + 60s;
  EXPECT_TRUE(reply_to(first_, {{"op", "obstacle_remove"}, {"name", "crate"}}).is_null());
}

TEST_F(OrdersTest, TakeAGoalOfJointPositions) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  EXPECT_TRUE(reply_to(first_, {{"op", "goal"}, {"arm", "north"}, {"q", {0, 1, 2, 0, 0, 0}}}).is_null())
      << "it waits for a cell, and is not refused";
}

Json preview_question(std::int64_t id) {
  return {{"op", "preview"}, {"id", id}, {"arm", "west"}, {"pose", {0.1, 0.2, 0.3, 0, 0, 0, 1}}};
}

TEST_F(OrdersTest, TakePreviewsFromThePageThatControls) {
  EXPECT_EQ(reply_to(first_, preview_question(-1)).at("text"), "this page does not control the cell");
  EXPECT_FALSE(orders_->take_preview());
  EXPECT_TRUE(take(first_, token_).at("done"));
  EXPECT_TRUE(reply_to(first_, preview_question(-2)).is_null());
  EXPECT_EQ(reply_to(second_, preview_question(-3)).at("text"), "this page does not control the cell");
  const auto question = orders_->take_preview();
  ASSERT_TRUE(question);
  EXPECT_EQ(question->page, 1U);
  EXPECT_EQ(question->id, -2);
  EXPECT_EQ(question->arm, 1);
  EXPECT_EQ(question->start.size(), 0);
  EXPECT_TRUE(question->X_WT.translation().isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_TRUE(question->X_WT.linear().isIdentity());
  EXPECT_FALSE(orders_->take_preview()) << "once";
}

TEST_F(OrdersTest, KeepOnlyTheNewestPreviewAndCountNone) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  for (int i = 1; i <= 1000; ++i) EXPECT_TRUE(reply_to(first_, preview_question(-i)).is_null());
  EXPECT_EQ(orders_->take_preview()->id, -1000);
  EXPECT_FALSE(orders_->take_preview());
  EXPECT_EQ(reply_to(first_, {{"id", 3}, {"op", "goal"}, {"arm", "south"}}).at("text"), "'south' is no arm of the cell")
      << "orders are not used up";
}

TEST_F(OrdersTest, ForgetThePreviewOfAPageThatNoLongerControls) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  EXPECT_TRUE(reply_to(first_, preview_question(-1)).is_null());
  EXPECT_TRUE(reply_to(first_, {{"id", 2}, {"op", "release"}}).at("done"));
  EXPECT_FALSE(orders_->take_preview());
  EXPECT_TRUE(take(first_, token_).at("done"));
  EXPECT_TRUE(reply_to(first_, preview_question(-1)).is_null());
  orders_->left(first_);
  EXPECT_FALSE(orders_->take_preview());
}

TEST_F(OrdersTest, RefuseMalformedPreviewsWithASentence) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  const auto text = [&](const char* key, const Json& value) {
    Json message = preview_question(-1);
    message[key] = value;
    const Json reply = reply_to(first_, message);
    EXPECT_EQ(reply.at("op"), "preview");
    EXPECT_FALSE(orders_->take_preview());
    return reply.at("text").get<std::string>();
  };
  EXPECT_EQ(text("arm", "south"), "'south' is no arm of the cell");
  EXPECT_EQ(text("arm", 3), "the order needs 'arm', a text of at most 128 bytes");
  EXPECT_EQ(text("pose", Json::array()), "the order needs 'pose', a list of 7 numbers");
  EXPECT_EQ(text("pose", {0, 0, "x", 0, 0, 0, 1}), "the order needs 'pose', a list of 7 numbers");
  EXPECT_EQ(text("pose", {0, 0, 0, 0, 0, 0, 0}), "the rotation of 'pose' must be a unit quaternion");
  EXPECT_EQ(text("pose", {0, 0, 1001.0, 0, 0, 0, 1}), "the position of 'pose' must be within 1000 m of the origin");
  EXPECT_EQ(text("start", {0, 0}), "the order needs 'start', a list of 6 numbers");
  EXPECT_EQ(text("start", {0, 0, 0, 0, 0, nullptr}), "the order needs 'start', a list of 6 numbers");
}

TEST_F(OrdersTest, MoveTheStartOfAPreviewWithinTheLimits) {
  EXPECT_TRUE(take(first_, token_).at("done"));
  Json message = preview_question(-1);
  message["start"] = {1e9, -1e9, 0, 0, 0, 0};
  EXPECT_TRUE(reply_to(first_, message).is_null());
  const planner::JointLimits& limits = file_.cell.arms[1].arm.limits;
  const auto question = orders_->take_preview();
  ASSERT_TRUE(question);
  EXPECT_EQ(question->start[0], limits.upper[0]);
  EXPECT_EQ(question->start[1], limits.lower[1]);
}

}  // namespace
}  // namespace hecaton::services
