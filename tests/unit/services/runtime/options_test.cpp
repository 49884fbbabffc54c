#include "services/runtime/options.hpp"

#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

std::optional<ExitCode> parse(std::vector<const char*> arguments, ServiceOptions& options,
                              Subject subject = Subject::kArm) {
  arguments.insert(arguments.begin(), "program");
  return parse_options(static_cast<int>(arguments.size()), arguments.data(), "tests", subject, options);
}

TEST(Options, AreParsed) {
  ServiceOptions options;
  ASSERT_EQ(parse({"cell.yaml", "--arm", "north", "--domain", "7", "--host", "left-pc", "--log-level", "Debug",
                   "--log-file", "x.log"},
                  options),
            std::nullopt);
  EXPECT_EQ(options.cell, "cell.yaml");
  EXPECT_EQ(options.arm, "north");
  EXPECT_EQ(options.domain, 7);
  EXPECT_EQ(options.host, "left-pc");
  EXPECT_EQ(options.log_level, LogLevel::kDebug);
  EXPECT_EQ(options.log_file, "x.log");
}

TEST(Options, IncludeACheckpointFile) {
  ServiceOptions options;
  ASSERT_EQ(parse({"cell.yaml", "--checkpoint", "run/world"}, options, Subject::kCell), std::nullopt);
  EXPECT_EQ(options.checkpoint, "run/world");
  ASSERT_EQ(parse({"cell.yaml", "--arm", "north", "--checkpoint", "run/north"}, options, Subject::kArm), std::nullopt);
  EXPECT_EQ(options.checkpoint, "run/north");
}

TEST(Options, DistinguishWrongUsageFromBadValues) {
  ServiceOptions options;
  EXPECT_EQ(parse({}, options), ExitCode::kUsage);
  EXPECT_EQ(parse({"cell.yaml"}, options), ExitCode::kUsage) << "--arm is missing";
  EXPECT_EQ(parse({"cell.yaml"}, options, Subject::kCell), std::nullopt);
  EXPECT_EQ(parse({"cell.yaml", "--domain", "200"}, options, Subject::kCell), ExitCode::kBadInput);
  EXPECT_EQ(parse({"cell.yaml", "--domain", "x"}, options, Subject::kCell), ExitCode::kBadInput);
  EXPECT_EQ(parse({"cell.yaml", "--log-level", "loud"}, options, Subject::kCell), ExitCode::kUsage);
  EXPECT_EQ(parse({"--help"}, options), ExitCode::kDone);
  EXPECT_EQ(parse({"--version"}, options), ExitCode::kDone);
}

class Domain : public testing::Test {
 protected:
  ~Domain() override { unsetenv("HECATON_DOMAIN"); }
};

TEST_F(Domain, IsTheOptionsThenTheEnvironmentsThenTheCellFiles) {
  ServiceOptions options;
  unsetenv("HECATON_DOMAIN");
  EXPECT_EQ(choose_domain(options, 42), 42);
  setenv("HECATON_DOMAIN", "17", 1);
  EXPECT_EQ(choose_domain(options, 42), 17);
  options.domain = 3;
  EXPECT_EQ(choose_domain(options, 42), 3);
}

TEST_F(Domain, RefusesABadEnvironmentVariable) {
  for (const char* value : {"200", "-1", "4x", "1.5", " 7"}) {
    setenv("HECATON_DOMAIN", value, 1);
    try {
      (void)choose_domain({}, 42);
      ADD_FAILURE() << value;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(),
                "environment: HECATON_DOMAIN = '" + std::string(value) + "' must be a whole number from 0 to 199");
    }
  }
}

}  // namespace
}  // namespace hecaton::services
