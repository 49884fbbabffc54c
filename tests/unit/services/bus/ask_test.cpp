#include "services/bus/ask.hpp"

#include <atomic>
#include <thread>

#include <idl/world.h>

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

class Ask : public BusTest {};

msg::WorldEditRequest request(std::uint64_t id) {
  msg::WorldEditRequest message;
  message.client("cli-1");
  message.request_id(id);
  message.kind(msg::EditKind::EDIT_REMOVE);
  message.name("pallet");
  return message;
}

TEST_F(Ask, AnswerIsTheOneToTheQuestion) {
  Writer<msg::WorldEditRequest> requests(here_);
  Reader<msg::WorldEditReply> replies(here_);
  std::jthread service([&](const std::stop_token& stop) {
    Reader<msg::WorldEditRequest> inbox(there_);
    Writer<msg::WorldEditReply> outbox(there_);
    while (!stop.stop_requested()) {
      [[maybe_unused]] const bool arrived = inbox.wait_for_data(10ms);
      for (const auto& sample : inbox.take()) {
        msg::WorldEditReply reply;
        reply.client("somebody else");
        reply.request_id(sample.value.request_id());
        EXPECT_TRUE(outbox.write(reply));
        reply.client(sample.value.client());
        reply.edition(40 + sample.value.request_id());
        EXPECT_TRUE(outbox.write(reply));
      }
    }
  });
  for (std::uint64_t id = 1; id <= 3; ++id) {
    const auto answer = ask(requests, replies, request(id), kPatience);
    ASSERT_EQ(answer.outcome, AskOutcome::kAnswered);
    EXPECT_EQ(answer.reply->client(), "cli-1");
    EXPECT_EQ(answer.reply->edition(), 40 + id);
  }
}

TEST_F(Ask, NobodyAndSilenceAreToldApart) {
  Writer<msg::WorldEditRequest> requests(here_);
  Reader<msg::WorldEditReply> replies(here_);
  EXPECT_EQ(ask(requests, replies, request(1), 20ms).outcome, AskOutcome::kNobody);
  const Reader<msg::WorldEditRequest> deaf(there_);
  ASSERT_TRUE(requests.wait_matched(1, kPatience));
  EXPECT_EQ(ask(requests, replies, request(2), 50ms).outcome, AskOutcome::kTimeout);
}

// As who stands by and becomes the one to answer only now: what was asked before it never heard.
TEST_F(Ask, WhoAnswersOnlyTheSecondTimeIsAskedAgain) {
  Writer<msg::WorldEditRequest> requests(here_);
  Reader<msg::WorldEditReply> replies(here_);
  std::atomic<int> heard = 0;
  std::jthread service([&](const std::stop_token& stop) {
    ReaderOptions every;
    every.conflate = false;
    Reader<msg::WorldEditRequest> inbox(there_, nullptr, every);
    Writer<msg::WorldEditReply> outbox(there_);
    while (!stop.stop_requested()) {
      [[maybe_unused]] const bool arrived = inbox.wait_for_data(10ms);
      for (const auto& sample : inbox.take()) {
        if (++heard < 2) continue;
        msg::WorldEditReply reply;
        reply.client(sample.value.client());
        reply.request_id(sample.value.request_id());
        EXPECT_TRUE(outbox.write(reply));
      }
    }
  });
  EXPECT_EQ(ask(requests, replies, request(1), 100ms).outcome, AskOutcome::kTimeout) << "asked once";
  heard = 0;
  EXPECT_EQ(ask(requests, replies, request(2), kPatience, 20ms).outcome, AskOutcome::kAnswered);
}

}  // namespace
}  // namespace hecaton::bus
