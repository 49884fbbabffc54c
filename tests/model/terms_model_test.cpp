// Explores every reachable state of a cell with two supervisors and two planners, within bounds. Each state must be
// safe, and the cell must recover once nothing fails any more. Steps that an exploration must have taken are listed,
// because a model that explores nothing proves nothing. Mutants without one of the rules must be caught.

#include "tests/model/terms_model.hpp"

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/model/terms_explorer.hpp"

namespace hecaton::services::model {
namespace {

using Checks = Explorer::Checks;
using Sentences = std::vector<std::string>;

std::string text_of(const Finding& finding) {
  std::string text = finding.wrong + "\n";
  for (const std::string& step : finding.trace) text += "  " + step + "\n";
  return text;
}

void print(const Finding& finding, std::chrono::duration<double> took) {
  std::printf("%zu states, %zu combinations of processes, %.1f s\n", finding.states, finding.combinations,
              took.count());
  for (const auto& [step, times] : finding.coverage) std::printf("%10zu  %s\n", times, step.c_str());
}

void expect_safe_and_recovering(const Bounds& bounds, const Sentences& passed) {
  const auto began = std::chrono::steady_clock::now();
  const Finding finding = Explorer({}, bounds, Checks::kSafetyAndRecovery).explore();
  print(finding, std::chrono::steady_clock::now() - began);
  EXPECT_EQ(finding.wrong, "") << text_of(finding);
  for (const std::string& step : passed) EXPECT_TRUE(finding.coverage.contains(step)) << step;
}

Sentences both(const Sentences& some, const Sentences& others) {
  Sentences all(some);
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

/// Terms up to 5 are enough for these.
const Sentences kFailovers{
    "supervisor 0 listened and becomes leader",
    "supervisor 1 listened and becomes leader",
    "supervisor 0 stood by and becomes leader",
    "supervisor 1 stood by and becomes leader",
    "supervisor 0 detects that it was stopped",
    "supervisor 1 detects that it was stopped",
    "supervisor 0 leads under a term not above a lease",
    "supervisor 1 leads under a term not above a lease",
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
    "the driver returned and may receive a command that it must refuse",
    "the driver returned and follows",
    "the driver returned without checkpoint and follows",
};

Sentences returns_of_supervisor(const std::string& number) {
  const std::string name = "supervisor " + number;
  return {name + " returned and leads", name + " returned without checkpoint and leads",
          name + " grants a term that another planner has"};
}

// Two leaders may not hear each other and grant leases to different planners. The driver follows one planner at a time,
// and never one that was replaced. Once nothing fails, one supervisor leads and the arm is commanded.
TEST(TermsModel, IsSafeAndRecoversOnceNothingFails) {
  expect_safe_and_recovering({.highest_term = 6}, both(kFailovers, {"supervisor 0 replaces planner q"}));
}

TEST(TermsModel, IsSafeAndRecoversWhenTheFirstSupervisorDies) {
  expect_safe_and_recovering({.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor0}},
                             both(kFailovers, returns_of_supervisor("0")));
}

const std::vector<Death> kBelowSupervisors{Death::kPlanner, Death::kDriver, Death::kDriverHost};

TEST(TermsModel, IsSafeAndRecoversWhenAPlannerOrTheDriverDies) {
  expect_safe_and_recovering({.highest_term = 5, .most_deaths = 1, .deaths = kBelowSupervisors},
                             both(kFailovers, both(kReturnsOfPlanners, kReturnsOfDrivers)));
}

// Each takes a minute or more; only `./run model` runs them.
TEST(TermsModelAtLength, IsSafeAndRecoversWhenTheSecondSupervisorDies) {
  expect_safe_and_recovering({.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor1}},
                             both(kFailovers, returns_of_supervisor("1")));
}

TEST(TermsModelAtLength, IsSafeAndRecoversWithMoreTerms) {
  expect_safe_and_recovering({.highest_term = 7}, kFailovers);
}

TEST(TermsModelAtLength, IsSafeAndRecoversWithMoreTermsWhenAPlannerOrTheDriverDies) {
  expect_safe_and_recovering({.highest_term = 6, .most_deaths = 1, .deaths = kBelowSupervisors},
                             both(kFailovers, both(kReturnsOfPlanners, kReturnsOfDrivers)));
}

TEST(TermsModelAtLength, IsSafeAndRecoversWhenTwoProcessesDie) {
  expect_safe_and_recovering(
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
  Checks checks;  ///< some mutants are safe and only do not recover
};

class TermsMutant : public testing::TestWithParam<Mutant> {};

TEST_P(TermsMutant, IsCaught) {
  const Mutant& mutant = GetParam();
  const Finding finding = Explorer(mutant.rules, mutant.bounds, mutant.checks).explore();
  EXPECT_NE(finding.wrong, "") << "not found in " << finding.states << " states";
  std::printf("after %zu states: %s", finding.states, text_of(finding).c_str());
}

const Bounds kNoDeaths{.highest_term = 5};
const Bounds kDriverDies{.highest_term = 4, .most_deaths = 1, .deaths = {Death::kDriver}};
const Bounds kSupervisorDies{.highest_term = 5, .most_deaths = 1, .deaths = {Death::kSupervisor0}};

INSTANTIATE_TEST_SUITE_P(
    Rules, TermsMutant,
    testing::Values(
        Mutant{"WithoutTheGate", {.gate = false}, kNoDeaths, Checks::kSafety},
        Mutant{"WithoutBindingATermToOnePlanner", {.binding = false}, kSupervisorDies, Checks::kSafety},
        Mutant{"WithoutTheDriversCheckpoint", {.driver_has_checkpoint = false}, kDriverDies, Checks::kSafety},
        Mutant{"WithoutUniqueTerms", {.unique_terms = false}, kNoDeaths, Checks::kSafetyAndRecovery},
        Mutant{"WithoutCountingObservedTerms", {.counts_observed = false}, kNoDeaths, Checks::kSafetyAndRecovery},
        Mutant{"WithoutTheDriversProof", {.driver_proves = false}, kSupervisorDies, Checks::kSafetyAndRecovery},
        Mutant{"WithoutThePlannersProof", {.planners_prove = false}, kNoDeaths, Checks::kSafetyAndRecovery}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace hecaton::services::model
