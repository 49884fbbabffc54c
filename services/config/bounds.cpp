#include "services/config/bounds.hpp"

#include "services/config/text.hpp"

namespace hecaton::config {

std::string Bounds::text() const {
  std::string suffix;
  if (!unit.empty()) suffix.append(" ").append(unit);
  if (low_open) return "above " + number_text(low) + " and at most " + number_text(high) + suffix;
  return "between " + number_text(low) + " and " + number_text(high) + suffix;
}

}  // namespace hecaton::config
