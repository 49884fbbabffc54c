#include "services/client/mode_orders.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace hecaton::client {
namespace {

const char* const kWithdrawn = "not carried out: a later hold or stop came first; send it again to resume";

bool have_common_arm(const ModeOrders::Arms& a, const ModeOrders::Arms& b) {
  if (a.empty() || b.empty()) return true;
  return std::any_of(a.begin(), a.end(),
                     [&](const auto& arm) { return std::find(b.begin(), b.end(), arm) != b.end(); });
}

void tell(const std::vector<ModeOrders::Told>& all, const ModeOutcome& outcome) {
  for (const ModeOrders::Told& told : all) told(outcome);
}

}  // namespace

ModeOrders::ModeOrders(Send send) : send_(std::move(send)) {
  threads_[0] = std::jthread([this](const std::stop_token& stop) { restrict(stop, ModeOrder::kStop, stop_); });
  threads_[1] = std::jthread([this](const std::stop_token& stop) { restrict(stop, ModeOrder::kHold, hold_); });
  threads_[2] = std::jthread([this](const std::stop_token& stop) { resume(stop); });
}

ModeOrders::~ModeOrders() {
  for (std::jthread& thread : threads_) thread.request_stop();
  {
    const std::scoped_lock lock(mutex_);
    if (resuming_) resuming_->interruption.request_stop();
  }
  for (std::jthread& thread : threads_) thread.join();
}

void ModeOrders::give(ModeOrder order, const Arms& arms, std::uint64_t giver, Told told) {
  std::vector<Told> withdrawn;
  std::string refusal;
  {
    const std::scoped_lock lock(mutex_);
    if (order == ModeOrder::kResume) {
      if (resumes_.size() < kMostResumes) {
        resumes_.push_back({arms, giver, std::move(told)});
      } else {
        refusal = "too many orders to resume wait; send it again later";
      }
    } else {
      withdrawn = withdraw_resumes([&](const Resume& one) { return have_common_arm(one.arms, arms); });
      if (resuming_ && have_common_arm(resuming_->arms, arms)) {
        resuming_->withdrawn = true;
        resuming_->interruption.request_stop();
      }
      Restriction& restriction = order == ModeOrder::kStop ? stop_ : hold_;
      restriction.wanted = true;
      restriction.whole_cell = restriction.whole_cell || arms.empty();
      restriction.arms.insert(arms.begin(), arms.end());
      if (restriction.told.size() < kMostAnswers) {
        restriction.told.push_back(std::move(told));
      } else {
        refusal = "it is carried out, but too many orders wait for the reply";
      }
    }
  }
  changed_.notify_all();
  tell(withdrawn, {false, kWithdrawn});
  if (!refusal.empty()) told({false, refusal});
}

void ModeOrders::withdraw(std::uint64_t giver) {
  std::vector<Told> withdrawn;
  {
    const std::scoped_lock lock(mutex_);
    withdrawn = withdraw_resumes([&](const Resume& one) { return one.giver == giver; });
  }
  tell(withdrawn, {false, "not carried out: the page that gave it has closed"});
}

std::vector<ModeOrders::Told> ModeOrders::withdraw_resumes(const std::function<bool(const Resume&)>& concerned) {
  std::vector<Told> told;
  std::erase_if(resumes_, [&](Resume& one) {
    if (!concerned(one)) return false;
    told.push_back(std::move(one.told));
    return true;
  });
  return told;
}

void ModeOrders::restrict(const std::stop_token& stop, ModeOrder order, Restriction& restriction) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return restriction.wanted; })) {
    Restriction now = std::exchange(restriction, {});
    restriction.under_way = true;
    lock.unlock();
    const Arms arms = now.whole_cell ? Arms() : Arms(now.arms.begin(), now.arms.end());
    const ModeOutcome outcome = send(order, arms, stop);
    tell(now.told, outcome);
    lock.lock();
    restriction.under_way = false;
    changed_.notify_all();
  }
}

void ModeOrders::resume(const std::stop_token& stop) {
  const auto stands = [](const Restriction& one) { return one.wanted || one.under_way; };
  std::unique_lock lock(mutex_);
  const auto is_due = [&] { return !resumes_.empty() && !stands(stop_) && !stands(hold_); };
  while (changed_.wait(lock, stop, is_due) && !stop.stop_requested()) {
    const Resume now = std::move(resumes_.front());
    resumes_.pop_front();
    const std::stop_token interrupted = resuming_.emplace(Resuming{now.arms, {}, false}).interruption.get_token();
    if (stop.stop_requested()) resuming_->interruption.request_stop();
    lock.unlock();
    ModeOutcome outcome = send(ModeOrder::kResume, now.arms, interrupted);
    lock.lock();
    if (resuming_->withdrawn && !outcome.done) outcome.text = kWithdrawn;
    resuming_.reset();
    lock.unlock();
    now.told(outcome);
    lock.lock();
  }
  // Only an end of this object leaves resumes behind.
  const std::vector<Told> left = withdraw_resumes([](const Resume&) { return true; });
  lock.unlock();
  tell(left, {false, "not carried out: the service ends"});
}

ModeOutcome ModeOrders::send(ModeOrder order, const Arms& arms, const std::stop_token& interrupted) const {
  try {
    return {true, send_(order, arms, interrupted).warning.text};
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
}

}  // namespace hecaton::client
