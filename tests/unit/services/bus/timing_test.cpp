// Deadlines and ownership inside one process; tests/cell/bus has their multi-process counterparts.
#include <algorithm>
#include <functional>
#include <set>

#include <idl/arm.h>
#include <idl/health.h>

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

class Timing : public BusTest {};

msg::ArmState state_of(const std::string& arm) {
  msg::ArmState state;
  state.arm(arm);
  return state;
}

struct Seen {
  std::vector<Event> events;
  void collect(Mailbox& mailbox) {
    for (auto& event : mailbox.take_events()) events.push_back(std::move(event));
  }
  [[nodiscard]] long count(EventKind kind, std::string_view key) const {
    return std::count_if(events.begin(), events.end(),
                         [&](const auto& event) { return event.kind == kind && event.key == key; });
  }
};

/// Waits for the whole span, to see that something does not happen.
template <class T>
void let_pass(Reader<T>& reader, Clock::duration span) {
  const auto until = Clock::now() + span;
  while (Clock::now() < until) {
    [[maybe_unused]] const bool arrived = reader.wait_for_data(until - Clock::now());
  }
}

TEST_F(Timing, ReportsAMissedDeadlineOncePerKeyAndSilence) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  Seen seen;
  ASSERT_TRUE(wait_until(reader, [&] { return writer.write(state_of("quiet")) && reader.latest("quiet") != nullptr; }));
  // Another key of the same writer goes on all the time and does not hide the silent one.
  ASSERT_TRUE(wait_until(reader, [&] {
    if (!writer.write(state_of("busy"))) return false;
    seen.collect(reader.mailbox());
    return seen.count(EventKind::kDeadlineMissed, "quiet") >= 1;
  }));
  // "quiet" may have been written more than once, with a silence between. After this wait all samples have arrived.
  let_pass(reader, 200ms);
  seen.collect(reader.mailbox());
  const auto reported = seen.count(EventKind::kDeadlineMissed, "quiet");
  let_pass(reader, 200ms);  // ten deadlines
  seen.collect(reader.mailbox());
  EXPECT_EQ(seen.count(EventKind::kDeadlineMissed, "quiet"), reported);

  // The key is written again and falls silent again.
  const auto received = [&] {
    for (const auto& sample : reader.take()) {
      if (sample.key == "quiet") return true;
    }
    return false;
  };
  ASSERT_TRUE(wait_until(reader, [&] { return writer.write(state_of("quiet")) && received(); }));
  EXPECT_TRUE(wait_until(reader, [&] {
    seen.collect(reader.mailbox());
    return seen.count(EventKind::kDeadlineMissed, "quiet") > reported;
  }));
}

// Fast DDS goes on reporting keys whose writer has left.
TEST_F(Timing, ReportsNoMissedDeadlinesOfAWriterThatLeft) {
  ReaderOptions options;
  options.deadline = 20ms;
  Reader<msg::ArmState> reader(there_, nullptr, options);
  auto writer = std::make_unique<Writer<msg::ArmState>>(here_);
  expect_matched(*writer, reader);
  ASSERT_TRUE(wait_until(reader, [&] { return writer->write(state_of("arm1")) && reader.latest("arm1") != nullptr; }));
  writer.reset();
  Seen seen;
  ASSERT_TRUE(wait_until(reader, [&] {
    seen.collect(reader.mailbox());
    return seen.count(EventKind::kPeerLost, "arm1") == 1;
  }));
  const auto missed = reader.counters().deadlines_missed;
  let_pass(reader, 200ms);  // ten deadlines
  EXPECT_EQ(reader.counters().deadlines_missed, missed);
}

TEST_F(Timing, ReportsNoMissedDeadlinesOfARetiredKey) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  ASSERT_TRUE(wait_until(reader, [&] { return writer.write(state_of("arm1")) && reader.latest("arm1") != nullptr; }));
  // Best-effort: the withdrawal may be lost. Its repetition waits until the last one had time to arrive, because the
  // new sample revives the key.
  ASSERT_TRUE(wait_until(reader, [&] {
    if (!writer.write(state_of("arm1")) || !writer.retire(state_of("arm1"))) return false;
    let_pass(reader, 100ms);
    return reader.latest("arm1") == nullptr;
  }));
  ASSERT_EQ(reader.latest("arm1"), nullptr);
  const auto missed = reader.counters().deadlines_missed;
  let_pass(reader, 200ms);
  EXPECT_EQ(reader.counters().deadlines_missed, missed);
}

/// Writes `kept` and waits for its missed deadline.
[[nodiscard]] bool reports_silence(Writer<msg::ArmState>& writer, Reader<msg::ArmState>& reader,
                                   const std::string& kept) {
  Seen seen;
  seen.collect(reader.mailbox());
  seen.events.clear();
  const auto received = [&] {
    for (const auto& sample : reader.take()) {
      if (sample.key == kept && !sample.disposed) return true;
    }
    return false;
  };
  if (!wait_until(reader, [&] { return writer.write(state_of(kept)) && received(); })) return false;
  return wait_until(reader, [&] {
    seen.collect(reader.mailbox());
    return seen.count(EventKind::kDeadlineMissed, kept) >= 1;
  });
}

// The end of a key must not end the deadlines of other keys.
TEST_F(Timing, KeepsDeadlinesAfterAnotherKeyWasRetired) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  for (const auto* gone : {"arm1", "arm2", "arm3"}) {
    ASSERT_TRUE(reports_silence(writer, reader, "kept"));
    ASSERT_TRUE(reports_silence(writer, reader, gone));
    ASSERT_TRUE(wait_until(reader, [&] {
      if (reader.latest(gone) == nullptr) return true;
      return !(writer.write(state_of(gone)) && writer.retire(state_of(gone)));
    }));
    ASSERT_TRUE(reports_silence(writer, reader, "kept")) << gone;
  }
}

TEST_F(Timing, KeepsDeadlinesAfterAnotherWriterLeft) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  for (const auto* gone : {"arm1", "arm2", "arm3"}) {
    Participant brief(domain_.number(), "brief", one_host());
    auto other = std::make_unique<Writer<msg::ArmState>>(brief);
    expect_matched(*other, reader);
    ASSERT_TRUE(reader.wait_matched(2, kPatience));
    ASSERT_TRUE(reports_silence(writer, reader, "kept"));
    ASSERT_TRUE(reports_silence(*other, reader, gone));
    other.reset();
    ASSERT_TRUE(wait_until(reader, [&] { return reader.matched() == 1; }));
    ASSERT_TRUE(reports_silence(writer, reader, "kept")) << gone;
  }
}

/// Of two keys the first is due first and ends before that. The silence of the second must be reported all the same.
class SecondDeadline : public BusTest {
 protected:
  void expect_second_reported(const std::function<void(Writer<msg::ArmState>&)>& go) {
    constexpr auto kDeadline = 300ms;
    ReaderOptions reader_options;
    reader_options.deadline = kDeadline;
    Participant other(domain_.number(), "other", one_host());
    first_ = std::make_unique<Writer<msg::ArmState>>(here_);
    Writer<msg::ArmState> second(other);
    Reader<msg::ArmState> reader(there_, nullptr, reader_options);
    ASSERT_TRUE(reader.wait_matched(2, kPatience));
    ASSERT_TRUE(first_->wait_matched(1, kPatience));
    ASSERT_TRUE(second.wait_matched(1, kPatience));
    const auto arrive = [&](Writer<msg::ArmState>& writer, const std::string& key) {
      return wait_until(reader, [&] { return writer.write(state_of(key)) && reader.latest(key) != nullptr; });
    };
    ASSERT_TRUE(arrive(*first_, "first"));
    ASSERT_TRUE(arrive(second, "second"));
    go(*first_);
    Seen seen;
    EXPECT_TRUE(wait_until(reader, [&] {
      seen.collect(reader.mailbox());
      return seen.count(EventKind::kDeadlineMissed, "second") >= 1;
    }));
  }
  std::unique_ptr<Writer<msg::ArmState>> first_;
};

TEST_F(SecondDeadline, IsReportedWhenTheFirstKeyIsRetired) {
  expect_second_reported([](auto& writer) { ASSERT_TRUE(writer.retire(state_of("first"))); });
}

TEST_F(SecondDeadline, IsReportedWhenTheFirstWriterLeaves) {
  expect_second_reported([this](auto&) { first_.reset(); });
}

TEST_F(SecondDeadline, IsReportedWhenTheFirstKeyIsSilent) {
  expect_second_reported([](auto&) {});
}

// A writer of greater strength, or a busy one, must not hide another one.
TEST_F(BusTest, ReadersHearAllWritersOfTheCellMode) {
  Participant third(domain_.number(), "third", one_host());
  Writer<msg::CellMode> leader(here_);
  Writer<msg::CellMode> other(third);
  Reader<msg::CellMode> reader(there_);
  ASSERT_TRUE(reader.wait_matched(2, kPatience));
  ASSERT_TRUE(leader.wait_matched(1, kPatience));
  ASSERT_TRUE(other.wait_matched(1, kPatience));
  msg::CellMode mode;
  mode.term(2);
  ASSERT_TRUE(leader.write(mode));
  ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == 1; }));
  mode.term(1);
  for (std::uint64_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(other.write(mode));
    ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == i + 2; }));
  }
  std::multiset<std::uint64_t> terms;
  for (const auto& sample : reader.take()) terms.insert(sample.value.term());
  EXPECT_EQ(terms.count(2), 1) << "hidden by the other writer";
  EXPECT_GE(terms.count(1), 1);
}

}  // namespace
}  // namespace hecaton::bus
