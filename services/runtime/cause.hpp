#pragma once
/// Causes as values: made in one line, asked by kind. No decision is taken on a text.

#include <string>
#include <utility>

#include <idl/cause.h>

namespace hecaton::services {

/// `subject`: the node, host, arm, obstacle, joint or link that it is about; `text`: one sentence for people.
[[nodiscard]] inline msg::Cause make_cause(msg::CauseKind kind, std::string subject, std::string text) {
  msg::Cause cause;
  cause.kind(kind);
  cause.subject(std::move(subject));
  cause.text(std::move(text));
  return cause;
}

/// True when there is nothing to explain.
[[nodiscard]] inline bool is_none(const msg::Cause& cause) {
  return cause.kind() == msg::CauseKind::CAUSE_NONE;
}

}  // namespace hecaton::services
