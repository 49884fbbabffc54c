#pragma once
/// Orders of clients of the Foxglove protocol: hold, resume and stop. The owner of the server decides whether it takes
/// any.

#include <cstdint>
#include <functional>
#include <string>

namespace hecaton::services::foxglove {

enum class OrderKind : std::uint8_t { kHold, kResume, kStop };

struct Order {
  OrderKind kind{};
  std::string arm;           ///< empty: the whole cell
  std::uint64_t client = 0;  ///< number of the session that gave it
};

struct OrderResult {
  bool done = false;
  std::string text;  ///< a sentence
};

/// Carries out an order. It does not block, and calls `answer` once, later or at once, in any thread.
using OrderSink = std::function<void(const Order& order, std::function<void(OrderResult)> answer)>;

}  // namespace hecaton::services::foxglove
