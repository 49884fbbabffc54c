#pragma once
/// What an exploration has passed, so that nobody takes for explored what cannot happen within its bounds.

#include <string>
#include <vector>

#include "tests/model/terms_model.hpp"

namespace hecaton::services::model {

/// What is worth telling of a step, sentences; of most nothing.
[[nodiscard]] std::vector<std::string> landmarks(const Cell& before, const Step& step, const Cell& after,
                                                 const Actors& actors);

}  // namespace hecaton::services::model
