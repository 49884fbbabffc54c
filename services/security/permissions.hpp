#pragma once
/// Roles of a secured cell, and the documents of DDS Security that say what each may do. No files, no cryptography.

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services {

/// What a participant may do. An operator gives goals and orders and edits obstacles. A viewer only reads; as
/// a recorder it also replies to orders to save.
enum class Role { kAgent, kSupervisor, kWorld, kDriver, kPlanner, kOperator, kViewer };
inline constexpr std::array kRoles{Role::kAgent,   Role::kSupervisor, Role::kWorld, Role::kDriver,
                                   Role::kPlanner, Role::kOperator,   Role::kViewer};
/// "planner"
[[nodiscard]] std::string_view role_name(Role role);

/// A role, and of a planner or driver the arms that it may command, or obey for. Empty: all arms.
struct Duty {
  Role role{};
  std::vector<std::string> arms;
  bool operator==(const Duty&) const = default;
};

/// One duty of each role, in the order of kRoles. `arms`: of the planner and the driver; empty: all arms.
[[nodiscard]] std::vector<Duty> all_duties(const std::vector<std::string>& arms = {});

/// All datagrams are encrypted, and samples of all topics but streams of states once more. No participant joins without
/// an identity, and permissions decide about each topic.
[[nodiscard]] std::string governance_xml();

/// The permissions of a role (DDS Security 1.1, section 9.4.1.3) for the identity with this subject. They allow exactly
/// the topics that the table of topics has for the role. `arms`: topics with a partition for each arm are allowed for
/// these arms only; empty: for all arms.
[[nodiscard]] std::string permissions_xml(Role role, const std::string& subject,
                                          std::chrono::system_clock::time_point from,
                                          std::chrono::system_clock::time_point until,
                                          const std::vector<std::string>& arms = {});

/// The `arms` of permissions_xml(), sorted; empty: all arms, or the role has no topic with a partition for each arm.
[[nodiscard]] std::vector<std::string> arms_in(const std::string& document);

/// What permissions_xml() of this program allows the role and the document does not: "may not write hecaton/Fault",
/// sorted. The document may be signed.
[[nodiscard]] std::vector<std::string> missing_permissions(Role role, const std::string& document);

/// When permissions expire; the earliest of several grants. Empty: the document does not say.
[[nodiscard]] std::optional<std::chrono::system_clock::time_point> permissions_expiry(const std::string& document);

/// "2027-01-31T12:00:00", in UTC
[[nodiscard]] std::string xml_time(std::chrono::system_clock::time_point time);

}  // namespace hecaton::services
