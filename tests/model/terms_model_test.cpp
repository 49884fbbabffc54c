// Explores every state that a cell of two supervisors and two planners can get into, within bounds, and judges each:
// safe whatever happens, and well again once nothing happens any more. What must be passed on the way is named, for a
// model that does not explore proves nothing. Mutants without one of the rules must be caught.

#include "tests/model/terms_model.hpp"

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/model/terms_explorer.hpp"

namespace hecaton::services::model {
namespace {

using Judges = Explorer::Judges;
using Sentences = std::vector<std::string>;

std::string text_of(const Finding& finding) {
  std::string text = finding.wrong + "\n";
  for (const std::string& step : finding.story) text += "  " + step + "\n";
  return text;
}

void print(const Finding& finding, std::chrono::duration<double> took) {
  std::printf("%zu states, %zu combinations of processes, %.1f s\n", finding.states, finding.combinations,
              took.count());
  for (const auto& [landmark, times] : finding.landmarks) std::printf("%10zu  %s\n", times, landmark.c_str());
}

void expect_nothing_wrong(const Bounds& bounds, const Sentences& passed) {
  const auto began = std::chrono::steady_clock::now();
  const Finding finding = Explorer({}, bounds, Judges::kSafetyAndCalm).explore();
  print(finding, std::chrono::steady_clock::now() - began);
  EXPECT_EQ(finding.wrong, "") << text_of(finding);
  for (const std::string& landmark : passed) EXPECT_TRUE(finding.landmarks.contains(landmark)) << landmark;
}

Sentences both(const Sentences& some, const Sentences& others) {
  Sentences all(some);
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

/// With terms up to 5 already.
const Sentences kTakeovers{
    "supervisor 0 listened and leads",
    "supervisor 1 listened and leads",
    "supervisor 0 stood by and leads",
    "supervisor 1 stood by and leads",
    "supervisor 0 was stopped, and finds out",
    "supervisor 1 was stopped, and finds out",
    "supervisor 0 leads under a term not above a mandate",
    "supervisor 1 leads under a term not above a mandate",
    "supervisor 0 replaces planner p",
    "supervisor 1 replaces planner p",
    "supervisor 1 replaces planner q",
    "the driver follows q after p",
    "the driver follows p after q",
};
const Sentences kReturnsOfPlanners{
    "planner p returned and is followed",
    "planner q returned and is followed",
};
const Sentences kReturnsOfDrivers{
    "the driver returned and may hear a command that it must refuse",
    "the driver returned and follows",
    "the driver returned without memory and follows",
};

Sentences returns_of_supervisor(const std::string& number) {
  const std::string name = "supervisor " + number;
  return {name + " returned and leads", name + " returned without memory and leads",
          name + " grants a term that another planner has"};
}

// Two leaders that do not hear each other, each with planners of its own, on any network: the driver follows one
// planner at a time and never one that was replaced, and once nothing fails one supervisor leads and the arm is
// commanded.
TEST(TermsModel, IsSafeAndWellAgainOnceNothingFails) {
  expect_nothing_wrong({.highest_term = 6}, both(kTakeovers, {"supervisor 0 replaces planner q"}));
}

TEST(TermsModel, AlsoWhenTheFirstSupervisorDies) {
  expect_nothing_wrong({.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor0}},
                       both(kTakeovers, returns_of_supervisor("0")));
}

const std::vector<Death> kBelowSupervisors{Death::kPlanner, Death::kDriver, Death::kDriverHost};

TEST(TermsModel, AlsoWhenAPlannerOrTheDriverDies) {
  expect_nothing_wrong({.highest_term = 5, .most_deaths = 1, .deaths = kBelowSupervisors},
                       both(kTakeovers, both(kReturnsOfPlanners, kReturnsOfDrivers)));
}

// Too long for every run: a minute and more each. `./run model` has them, too.
TEST(TermsModelAtLength, AlsoWhenTheSecondSupervisorDies) {
  expect_nothing_wrong({.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor1}},
                       both(kTakeovers, returns_of_supervisor("1")));
}

TEST(TermsModelAtLength, AmongMoreTerms) {
  expect_nothing_wrong({.highest_term = 7}, kTakeovers);
}

TEST(TermsModelAtLength, AmongMoreTermsAlsoWhenAPlannerOrTheDriverDies) {
  expect_nothing_wrong({.highest_term = 6, .most_deaths = 1, .deaths = kBelowSupervisors},
                       both(kTakeovers, both(kReturnsOfPlanners, kReturnsOfDrivers)));
}

TEST(TermsModelAtLength, AlsoWhenTwoDie) {
  expect_nothing_wrong(
      {.highest_term = 4,
       .most_deaths = 2,
       .deaths = {Death::kSupervisor0, Death::kSupervisor1, Death::kPlanner, Death::kDriver}},
      both(both(returns_of_supervisor("0"), returns_of_supervisor("1")),
           both(kReturnsOfPlanners, {"the driver returned and follows", "the driver follows q after p"})));
}

struct Mutant {
  const char* name;
  Rules rules;
  Bounds bounds;
  Judges judges;  ///< some are safe, and only do not become well again
};

class TermsMutant : public testing::TestWithParam<Mutant> {};

TEST_P(TermsMutant, IsCaught) {
  const Mutant& mutant = GetParam();
  const Finding finding = Explorer(mutant.rules, mutant.bounds, mutant.judges).explore();
  EXPECT_NE(finding.wrong, "") << "not found in " << finding.states << " states";
  std::printf("after %zu states: %s", finding.states, text_of(finding).c_str());
}

const Bounds kNobodyDies{.highest_term = 5};
const Bounds kDriverDies{.highest_term = 4, .most_deaths = 1, .deaths = {Death::kDriver}};
const Bounds kSupervisorDies{.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor0}};

INSTANTIATE_TEST_SUITE_P(
    Rules, TermsMutant,
    testing::Values(Mutant{"WithoutAGate", {.gate = false}, kNobodyDies, Judges::kSafety},
                    Mutant{"WithoutGivingATermToOnePlanner", {.binding = false}, kSupervisorDies, Judges::kSafety},
                    Mutant{"WithoutTheDriversMemory", {.driver_remembers = false}, kDriverDies, Judges::kSafety},
                    Mutant{"WithoutTermsOfOnesOwn", {.unique_terms = false}, kNobodyDies, Judges::kSafetyAndCalm},
                    Mutant{"WithoutCountingWhatWasHeard", {.counts_heard = false}, kNobodyDies, Judges::kSafetyAndCalm},
                    Mutant{"WithoutTheDriversProof", {.driver_proves = false}, kSupervisorDies, Judges::kSafetyAndCalm},
                    Mutant{"WithoutThePlannersProof", {.planners_prove = false}, kNobodyDies, Judges::kSafetyAndCalm}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace hecaton::services::model
