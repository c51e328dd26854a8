#include "viewer/interface/option_panel.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

namespace sideray::viewer {
namespace {

const std::string unchanged = "\n";

std::vector<std::string> choices_of(const sideray_option& row) {
  if (row.type == SIDERAY_OPTION_FLAG) return {"false", "true"};
  return {row.choices, row.choices + row.choice_count};
}

bool is_shown(const sideray_option& row) {
  return !is_decided_by_window(row.name) && row.type != SIDERAY_OPTION_SIZE;
}

// Returns whether some value of the option changes the picture of a scene with these facts.
bool makes_difference(const sideray_option& row, const Options& options, const sideray_scene_facts& facts) {
  const auto reduced = [&](Options set) {
    check([&](sideray_error* error) { return sideray_options_reduce(set.get(), &facts, error); });
    return set;
  };
  const Options now = reduced(options);
  for (const std::string& value : choices_of(row)) {
    Options trial = options;
    trial.set(row.name, value);
    if (sideray_options_check(trial.get(), nullptr) == SIDERAY_OK && !sideray_options_equal(reduced(trial).get(), now.get()))
      return true;
  }
  return false;
}

std::string reason_of(const sideray_option& row, const Options& options, const sideray_scene_facts& facts) {
  const char* reason = nullptr;
  if (!sideray_options_applies(options.get(), row.name, &reason)) return reason ? reason : "not read";
  const bool is_finite = row.type == SIDERAY_OPTION_SWITCH || row.type == SIDERAY_OPTION_CHOICE;
  if (is_finite && std::string(row.name) != "quality" && !makes_difference(row, options, facts))
    return "no value of it makes a difference in this scene";
  return "";
}

void explain(const sideray_option& row, const std::string& reason) {
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(360);
  ImGui::Text("--%s", row.name);
  ImGui::TextUnformatted(row.help);
  if (*row.default_value) ImGui::TextDisabled("default: %s", row.default_value);
  if (!reason.empty()) ImGui::TextColored({1.0f, 0.75f, 0.4f, 1.0f}, "left out: %s", reason.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

}  // namespace

void OptionPanel::find_reasons(const Options& options, const sideray_scene_facts& facts) {
  if (known_ && sideray_options_equal(known_->get(), options.get()) && known_triangles_ == facts.triangles) return;
  reasons_.clear();
  for (size_t i = 0; i < sideray_option_count(); ++i) {
    const sideray_option& row = *sideray_option_at(i);
    if (!is_shown(row)) continue;
    if (const std::string reason = reason_of(row, options, facts); !reason.empty()) reasons_[row.name] = reason;
  }
  known_ = options;
  known_triangles_ = facts.triangles;
  written_.clear();
}

// Draws a choice of the values. Returns the chosen one, "" for the default, or `unchanged`.
std::string OptionPanel::choose(const sideray_option& row, const Options& options) {
  std::string chosen = unchanged;
  const std::string now = options[row.name];
  if (!ImGui::BeginCombo("##value", now.empty() ? "auto" : now.c_str())) return chosen;
  for (const std::string& value : choices_of(row))
    if (ImGui::Selectable(value.c_str(), value == now)) chosen = value;
  ImGui::EndCombo();
  return chosen;
}

std::string OptionPanel::write(const sideray_option& row, const Options& options) {
  auto [at, is_new] = written_.try_emplace(row.name);
  std::array<char, 64>& text = at->second;
  if (is_new) std::strncpy(text.data(), options[row.name].c_str(), text.size() - 1);
  ImGui::InputTextWithHint("##value", row.placeholder, text.data(), text.size());
  if (!ImGui::IsItemDeactivatedAfterEdit()) return unchanged;
  const std::string result = text.data();
  written_.erase(at);
  return result == options[row.name] ? unchanged : result;
}

std::optional<std::string> OptionPanel::draw_row(const sideray_option& row, const Options& options) {
  const auto reason = reasons_.find(row.name);
  const bool is_idle = reason != reasons_.end();
  ImGui::PushID(row.name);
  ImGui::BeginDisabled(is_idle);
  ImGui::BeginGroup();
  ImGui::AlignTextToFramePadding();
  if (options.is_set(row.name))
    ImGui::TextColored({0.55f, 0.8f, 1.0f, 1.0f}, "%s", row.name);
  else
    ImGui::TextUnformatted(row.name);
  ImGui::SameLine(132);
  ImGui::SetNextItemWidth(170);
  const bool is_list = row.type == SIDERAY_OPTION_CHOICE || row.type == SIDERAY_OPTION_SWITCH || row.type == SIDERAY_OPTION_FLAG;
  std::string value = is_list ? choose(row, options) : write(row, options);
  ImGui::EndGroup();
  const bool is_hovered = ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled);
  if (options.is_set(row.name)) {
    ImGui::SameLine();
    if (ImGui::SmallButton("default")) value = "";
  }
  ImGui::EndDisabled();
  if (is_hovered) explain(row, is_idle ? reason->second : "");  // not dimmed like the option itself
  ImGui::PopID();
  return value == unchanged ? std::nullopt : std::optional(value);
}

bool OptionPanel::draw(Options& options, const sideray_scene_facts& facts, std::string& message) {
  find_reasons(options, facts);
  std::optional<std::pair<std::string, std::string>> change;
  std::vector<std::string> groups{"Most used"};
  for (const int32_t diagnostic : {0, 1})  // diagnostics last
    for (size_t i = 0; i < sideray_option_count(); ++i) {
      const sideray_option& row = *sideray_option_at(i);
      if ((row.diagnostic != 0) == (diagnostic != 0) && std::find(groups.begin(), groups.end(), row.group) == groups.end())
        groups.emplace_back(row.group);
    }
  for (const std::string& group : groups) {
    const bool is_first = group == groups.front();
    bool is_open = is_first, has_title = is_first;
    for (size_t i = 0; i < sideray_option_count(); ++i) {
      const sideray_option& row = *sideray_option_at(i);
      if (row.group != group || !is_shown(row)) continue;
      if (!has_title) is_open = ImGui::TreeNodeEx(group.c_str(), ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_Framed);
      has_title = true;
      if (!is_open) break;
      if (const auto value = draw_row(row, options)) change = {row.name, *value};
    }
  }
  if (!change) return false;
  try {
    Options trial = options;
    trial.set(change->first, change->second);
    trial.require_consistent();
    options = std::move(trial);
    message.clear();
    return true;
  } catch (const Error& error) {
    message = error.what();
    return false;
  }
}

}  // namespace sideray::viewer
