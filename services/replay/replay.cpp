#include "services/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <utility>

namespace hecaton::services::replay {
namespace {

using view::Json;

/// Since the begin of the recording [ms], to the nanosecond.
double offset(bus::Clock::time_point time, bus::Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(time - begin).count();
}

bus::Clock::duration milliseconds(double value) {
  return std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double, std::milli>(value));
}

const char* name_of(MarkKind kind) {
  switch (kind) {
    case MarkKind::kFault:
      return "fault";
    case MarkKind::kGoal:
      return "goal";
    case MarkKind::kMode:
      break;
  }
  return "mode";
}

/// A number of a command; empty: it has none. JSON has no infinite ones.
std::optional<double> number(const Json& command, const char* field) {
  const auto found = command.find(field);
  if (found == command.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::string text(const Json& command, const char* field) {
  const auto found = command.find(field);
  return found != command.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

void Replay::command(std::string_view json) {
  const Json command = Json::parse(json, nullptr, false);
  if (!command.is_object()) return;
  const std::string op = text(command, "op");
  const RecordingIndex& index = cell_.index();
  if (op == "play") {
    if (now() >= index.end) seek(index.begin);
    plays_ = true;
  } else if (op == "pause") {
    plays_ = false;
  } else if (op == "speed") {
    if (const auto speed = number(command, "value")) speed_ = std::clamp(*speed, kSlowest, kFastest);
  } else if (op == "seek") {
    const auto at = number(command, "at");
    if (at) seek(index.begin + milliseconds(std::clamp(*at, 0.0, offset(index.end, index.begin))));
  } else if (op == "step") {
    if (const auto by = number(command, "by")) step(*by < 0.0 ? -1 : 1, text(command, "arm"));
  }
}

void Replay::seek(bus::Clock::time_point time) {
  cell_.move_to(time);
  ++leaps_;
}

void Replay::step(int by, const std::string& arm) {
  plays_ = false;
  auto time = by < 0 ? cell_.previous_tick(arm) : cell_.next_tick(arm);
  if (!time) time = by < 0 ? cell_.previous_state(arm) : cell_.next_state(arm);
  if (time) seek(*time);
}

void Replay::advance(bus::Clock::duration elapsed) {
  if (!plays_) return;
  const auto step = std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double>(elapsed) * speed_);
  cell_.move_to(now() + step);
  plays_ = now() < cell_.index().end;
}

std::chrono::milliseconds Replay::unix_time() const {
  return std::chrono::duration_cast<std::chrono::milliseconds>(now().time_since_epoch());
}

Json Replay::playback_json() const {
  return {{"type", "playback"}, {"at", offset(now(), cell_.index().begin)}, {"plays", plays_}, {"speed", speed_}};
}

Json Replay::recording_json() const {
  const RecordingIndex& index = cell_.index();
  Json files = Json::array();
  for (const RecordedPart& part : index.parts) {
    files.push_back(std::filesystem::path(part.path).filename().string());
  }
  Json marks = Json::array();
  for (const Mark& mark : index.marks) {
    marks.push_back({{"kind", name_of(mark.kind)},
                     {"at", offset(mark.at, index.begin)},
                     {"until", mark.until ? Json(offset(*mark.until, index.begin)) : Json(nullptr)},
                     {"subject", mark.subject},
                     {"text", mark.text},
                     {"severity", mark.severity}});
  }
  const auto begin = std::chrono::duration_cast<std::chrono::milliseconds>(index.begin.time_since_epoch());
  return {{"type", "recording"},    {"files", std::move(files)},
          {"begin", begin.count()}, {"length", offset(index.end, index.begin)},
          {"notes", index.notes},   {"marks", std::move(marks)}};
}

}  // namespace hecaton::services::replay
