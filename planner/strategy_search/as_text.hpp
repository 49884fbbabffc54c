#pragma once
/// Evaluations and strategies as a line of text, the same bits when they are read again: what a search keeps in its
/// file and what its processes tell each other.

#include <optional>
#include <string>

#include "planner/strategy_search/evaluate.hpp"

namespace hecaton::planner {

/// Numbers and spaces only.
[[nodiscard]] std::string text_of(const Evaluation& evaluation);
[[nodiscard]] std::string text_of(const SystemStrategy& strategy);

/// Nothing when the text is something else, or was cut off.
[[nodiscard]] std::optional<Evaluation> evaluation_of(const std::string& text);
[[nodiscard]] std::optional<SystemStrategy> strategy_of(const std::string& text);

}  // namespace hecaton::planner
