#pragma once
/// Orders of clients of the Foxglove protocol: hold, resume and stop.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "services/view/web_session.hpp"

namespace hecaton::services::foxglove {

enum class OrderKind : std::uint8_t { kHold, kResume, kStop };

struct Order {
  OrderKind kind{};
  std::string arm;   ///< empty: the whole cell
  WebClient client;  ///< that gave it
};

struct OrderResult {
  bool done = false;
  std::string text;  ///< a sentence
};

/// The rule for clients that give orders, and what carries them out.
struct OrderReceiver {
  /// A client that has opened its session with this token may; null: none may.
  std::function<bool(std::string_view token)> accepts = nullptr;
  /// Carries out an order. It does not block, and calls `answer` once, later or at once, in any thread.
  std::function<void(const Order& order, std::function<void(OrderResult)> answer)> carry_out = nullptr;
};

}  // namespace hecaton::services::foxglove
