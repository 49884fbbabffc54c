// The three experiments of [Lahouar06, section 4] on our cells: the local planner alone fails where the paper says so,
// boundary following succeeds, the contact monitor sees no contact; in virtual time.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton {
namespace {

constexpr const char* kDeployed = HECATON_SOURCE_DIR "/deploy/cells/";
constexpr const char* kOfTests = HECATON_SOURCE_DIR "/tests/data/cells/";

/// `candidates`: of the rollouts; 0: as the paper plans.
planner::BatchReport simulate(const std::string& name, const char* method, int tasks, int candidates = 0,
                              const std::string& folder = kDeployed) {
  planner::Cell cell = config::load_cell_file(folder + name + ".yaml").cell;
  for (auto& arm : cell.arms) {
    EXPECT_TRUE(arm.select_method(method));
    arm.parameters.rollout.candidates = candidates;
  }
  planner::BatchOptions options;
  options.tasks = tasks;
  options.seed = 11;
  options.threads = 2;
  planner::BatchReport report = planner::simulate_tasks(cell, options);
  EXPECT_EQ(report.failure, std::nullopt);
  EXPECT_EQ(report.tasks, tasks);
  EXPECT_EQ(report.contacts, 0U) << report.smallest.a << " – " << report.smallest.b;
  EXPECT_TRUE(report.has_smallest);
  EXPECT_GT(report.smallest.distance, 0.0);
  return report;
}

// Fig. 12: "These results can not be reached by using only the local planner."
TEST(Experiments, OnlyBoundaryFollowingTakesTheBarThroughTheLadder) {
  EXPECT_EQ(simulate("puma_ladder", "local", 10).reached, 0);
  EXPECT_GE(simulate("puma_ladder", "boundary_following", 20).reached, 14);
}

// Looking ahead finds the way through at once, where following boundaries in subspaces drawn blindly takes up to
// minutes.
TEST(Experiments, WithRolloutsTheBarPassesTheLadderAlwaysAndSoon) {
  const planner::BatchReport report = simulate("puma_ladder", "boundary_following", 20, 8);
  EXPECT_EQ(report.reached, 20);
  EXPECT_LT(*std::max_element(report.reach_times.begin(), report.reach_times.end()), 15.0);
}

// Fig. 13: "This task would not be possible if we used only the local planner."
TEST(Experiments, OnlyBoundaryFollowingExchangesTheCarriedObjects) {
  EXPECT_EQ(simulate("two_puma_carry", "local", 10).reached, 0);
  EXPECT_EQ(simulate("two_puma_carry", "boundary_following", 40).reached, 40);
}

// Fig. 14. The paper does not say that the local planner always fails here, and it does not: it loses some goals for
// good.
TEST(Experiments, ThreeArmsExchangePlaces) {
  const int alone = simulate("three_puma", "local", 300).reached;
  const int following = simulate("three_puma", "boundary_following", 300).reached;
  EXPECT_LT(alone, 297);
  EXPECT_GE(following, 297);
}

// The hard set: each arm stands in another's straight way.
TEST(Experiments, WithRolloutsAllHardTasksAreReached) {
  EXPECT_LT(simulate("three_puma_dense", "local", 90).reached, 80);
  EXPECT_EQ(simulate("three_puma_dense", "boundary_following", 90, 8).reached, 90);
}

// An arm that asks back before the other arm could yield must wait longer next time. Otherwise both ask in turns until
// their time is over.
TEST(Experiments, HastyArmsPassEachOtherHeadOn) {
  EXPECT_EQ(simulate("two_puma_head_on", "boundary_following", 24, 0, kOfTests).reached, 24);
}

// A stretched arm beside the disc's line can hardly leave it, and another arm may stand in its way out.
TEST(Experiments, ASlowDiscHitsNoArm) {
  planner::Cell cell = config::load_cell_file(std::string(kOfTests) + "three_planar_disc.yaml").cell;
  planner::BatchOptions options;
  options.tasks = 36;
  options.seed = 11;
  options.threads = 2;
  const planner::BatchReport report = planner::simulate_tasks(cell, options);
  EXPECT_EQ(report.reached, 36);
  EXPECT_EQ(report.contacts, 0U) << report.smallest.a << " – " << report.smallest.b;
  EXPECT_GT(report.smallest.distance, 0.0);
}

// Reacting alone, and looking ahead only when obstructed, one of these arms was pushed into another's way and hit.
TEST(Experiments, WhatCrossesTheCellIsForeseen) {
  planner::Cell cell = config::load_cell_file(std::string(kOfTests) + "four_puma_crossed.yaml").cell;
  for (auto& arm : cell.arms) arm.arm.limits.velocity.setConstant(3.0);
  planner::BatchOptions options;
  options.tasks = 24;
  options.seed = 8;
  options.threads = 2;
  const planner::BatchReport report = planner::simulate_tasks(cell, options);
  EXPECT_EQ(report.failure, std::nullopt);
  EXPECT_EQ(report.reached, 24);
  EXPECT_EQ(report.contacts, 0U) << report.smallest.a << " – " << report.smallest.b;
  EXPECT_GT(report.smallest.distance, 0.02);
}

}  // namespace
}  // namespace hecaton
