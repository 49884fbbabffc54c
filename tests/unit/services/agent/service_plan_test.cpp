#include "services/agent/service_plan.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using Names = std::vector<std::string>;

// Only the fields that the plan reads; it needs no robot model.
config::CellFile cell_on_two_hosts() {
  config::CellFile file;
  file.path = "cell.yaml";
  file.hosts = {{"pc1", "10.0.0.1"}, {"pc2", "10.0.0.2"}};
  file.world_host = "pc2";
  file.supervision.host = "pc1";
  for (const auto* name : {"a", "b"}) {
    file.cell.arms.emplace_back();
    file.cell.arms.back().arm.name = name;
  }
  file.arm_hosts = {{"pc1", ""}, {"pc2", ""}};
  return file;
}

Names names(const std::vector<PlannedService>& services) {
  Names all;
  for (const PlannedService& service : services) all.push_back(service.name);
  return all;
}

TEST(ServicePlan, PlansAllServicesWithoutAHost) {
  const auto services = plan_services(cell_on_two_hosts(), "");
  EXPECT_EQ(names(services), (Names{"world", "supervisor", "driver-a", "planner-a", "driver-b", "planner-b"}));
  EXPECT_EQ(planned_hosts(cell_on_two_hosts(), ""), (Names{"pc1", "pc2"}));
}

TEST(ServicePlan, PlansTheServicesOfOneHost) {
  EXPECT_EQ(names(plan_services(cell_on_two_hosts(), "pc1")), (Names{"supervisor", "driver-a", "planner-a"}));
  EXPECT_EQ(names(plan_services(cell_on_two_hosts(), "pc2")), (Names{"world", "driver-b", "planner-b"}));
  EXPECT_EQ(planned_hosts(cell_on_two_hosts(), "pc2"), Names{"pc2"});
}

TEST(ServicePlan, PassesCellArmAndHostAsArguments) {
  const auto services = plan_services(cell_on_two_hosts(), "pc2");
  EXPECT_EQ(services[0].arguments, (Names{"cell.yaml", "--host", "pc2"}));
  EXPECT_EQ(services[2].arguments, (Names{"cell.yaml", "--arm", "b", "--host", "pc2"}));
  EXPECT_EQ(services[2].node, "planner/b");
  EXPECT_EQ(services[2].program, "hecaton-planner");
}

TEST(ServicePlan, PlansStandbysOnTheirOwnHosts) {
  config::CellFile file = cell_on_two_hosts();
  file.arm_hosts[0].standby_host = "pc2";
  file.supervision.standby_host = "pc2";
  EXPECT_EQ(names(plan_services(file, "pc1")), (Names{"supervisor", "driver-a", "planner-a"}));
  const auto services = plan_services(file, "pc2");
  EXPECT_EQ(names(services), (Names{"world", "supervisor@pc2", "planner-a@pc2", "driver-b", "planner-b"}));
  EXPECT_EQ(services[2].node, "planner/a@pc2");
  EXPECT_EQ(services[2].arguments, (Names{"cell.yaml", "--arm", "a", "--host", "pc2"}));
}

TEST(ServicePlan, PlansTheRos2ServiceOnItsHost) {
  config::CellFile file = cell_on_two_hosts();
  file.ros2 = config::Ros2{};
  file.ros2->host = "pc1";
  const auto services = plan_services(file, "pc1");
  EXPECT_EQ(names(services), (Names{"supervisor", "driver-a", "planner-a", "ros2"}));
  EXPECT_EQ(services.back().program, "hecaton-ros2");
  EXPECT_EQ(services.back().arguments, (Names{"cell.yaml", "--host", "pc1"}));
}

TEST(ServicePlan, RejectsAnUnknownHostWithTheAllowedNames) {
  const auto refusal = [](const auto& ask) -> std::string {
    try {
      ask();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "not refused";
  };
  const config::CellFile file = cell_on_two_hosts();
  EXPECT_EQ(refusal([&] { static_cast<void>(plan_services(file, "pc3")); }),
            "cell.yaml: --host 'pc3' must be one of pc1, pc2");
  EXPECT_EQ(refusal([&] { require_host(file, ""); }), "cell.yaml: --host '' must be one of pc1, pc2");
  EXPECT_EQ(refusal([&] { require_host(file, "pc2"); }), "not refused");
}

}  // namespace
}  // namespace hecaton::services
