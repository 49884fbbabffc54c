#include "planner/methods/registry.hpp"

#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "planner/local/parameters.hpp"
#include "planner/methods/boundary_following/boundary_following.hpp"

namespace hecaton::planner {
namespace {

class Renamed final : public MotionMethod {
 public:
  explicit Renamed(std::string_view name) : MotionMethod({.name = name, .summary = "a method of a test"}) {}
};

TEST(MethodRegistry, ListsEveryBuiltInMethodOnce) {
  std::set<std::string_view> names;
  for (const MethodTraits& traits : built_in_methods().traits()) {
    EXPECT_TRUE(names.insert(traits.name).second) << traits.name;
    EXPECT_FALSE(traits.summary.empty()) << traits.name;
    EXPECT_EQ(built_in_method(traits.name)->traits().name, traits.name);
  }
  EXPECT_TRUE(names.contains(default_method()->traits().name));
}

TEST(MethodRegistry, AddsAMethodToACopyAlone) {
  MethodRegistry methods = built_in_methods();
  methods.add([] { return std::make_shared<Renamed>("spring"); });
  EXPECT_EQ(methods.names().back(), "spring");
  EXPECT_EQ(methods.names().size(), built_in_methods().names().size() + 1);
  EXPECT_EQ(methods.make_all().back()->traits().name, "spring");
}

TEST(MethodRegistry, RejectsASecondMethodOfTheSameName) {
  MethodRegistry methods = built_in_methods();
  EXPECT_THROW(methods.add([] { return std::make_shared<Renamed>("local"); }), std::invalid_argument);
}

TEST(MethodRegistry, ErrorForUnknownNameListsTheAllowedOnes) {
  try {
    (void)built_in_method("magic");
    FAIL() << "magic is no method";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("method = magic must be one of local, single_subspace"), std::string::npos)
        << error.what();
  }
}

TEST(MethodRegistry, DefaultParametersOfAllMethodsAreConsistent) {
  for (const auto& method : built_in_methods().make_all()) {
    EXPECT_EQ(method->validate(), std::nullopt) << method->traits().name;
  }
}

TEST(FollowerParameters, ErrorsNameKeyValueAndRule) {
  BoundaryFollowing method;
  method.parameters.exit_fraction = 1.0;
  EXPECT_EQ(method.validate(), "follower.exit_fraction = 1 must be between 0 and 1, both excluded");
  method.parameters = {};
  method.parameters.resample_after = -1.0;
  EXPECT_EQ(method.validate(), "follower.resample_after = -1 must be 0 (never) or a time in seconds");
  method.parameters = {};
  method.parameters.resample_longest = 0.5;
  EXPECT_EQ(method.validate(),
            "follower.resample_longest = 0.5 must be a time in seconds, no shorter than resample_after = 1");
}

}  // namespace
}  // namespace hecaton::planner
