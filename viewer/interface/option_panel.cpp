#include "viewer/interface/option_panel.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "viewer/interface/rows.h"

namespace sideray::viewer {
namespace {

const std::string unchanged = "\n";
const std::string most_used = "Most used";  // the group without a title

struct Change {
  std::string option, value;  // value "": the default
};

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

void show_help(const sideray_option& row, const std::string& reason) {
  show_beside_panel([&] {
    ImGui::TextColored(blue, "--%s", row.name);
    ImGui::TextUnformatted(row.help);
    if (*row.default_value) ImGui::TextDisabled("default: %s", row.default_value);
    if (!reason.empty()) ImGui::TextColored(warm, "left out: %s", reason.c_str());
  });
}

// Returns the titles of the groups in the order of the table, except that diagnostics are last.
std::vector<std::string> titles_of_groups() {
  std::vector<std::string> titles{most_used};
  for (const bool is_diagnostic : {false, true})
    for (size_t i = 0; i < sideray_option_count(); ++i) {
      const sideray_option& row = *sideray_option_at(i);
      if ((row.diagnostic != 0) == is_diagnostic && std::find(titles.begin(), titles.end(), row.group) == titles.end())
        titles.emplace_back(row.group);
    }
  return titles;
}

std::vector<const sideray_option*> rows_of(const std::string& group) {
  std::vector<const sideray_option*> rows;
  for (size_t i = 0; i < sideray_option_count(); ++i)
    if (const sideray_option& row = *sideray_option_at(i); row.group == group && is_shown(row)) rows.push_back(&row);
  return rows;
}

// Gives an option its new value. Returns false if that contradicts another option, and `message` says which.
bool apply(const Change& change, Options& options, std::string& message) {
  try {
    Options trial = options;
    trial.set(change.option, change.value);
    trial.require_consistent();
    options = std::move(trial);
    message.clear();
    return true;
  } catch (const Error& error) {
    message = error.what();
    return false;
  }
}

// Draws a group's title, blue if one of its options is set. Returns whether the group is open.
bool draw_title(const std::string& group, const std::vector<const sideray_option*>& rows, const Options& options) {
  const bool is_set = std::any_of(rows.begin(), rows.end(), [&](const sideray_option* row) { return options.is_set(row->name); });
  ImGui::PushStyleColor(ImGuiCol_Text, is_set ? blue : ImGui::GetStyleColorVec4(ImGuiCol_Text));
  const bool opens = is_open(group.c_str());
  ImGui::PopStyleColor();
  return opens;
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

// Returns the value that the user gives the option; empty: none.
std::optional<std::string> OptionPanel::draw_row(const sideray_option& row, const Options& options) {
  const auto reason = reasons_.find(row.name);
  const bool is_idle = reason != reasons_.end(), is_set = options.is_set(row.name);
  const bool is_list = row.type == SIDERAY_OPTION_CHOICE || row.type == SIDERAY_OPTION_SWITCH || row.type == SIDERAY_OPTION_FLAG;
  ImGui::PushID(row.name);
  ImGui::BeginDisabled(is_idle);
  begin_row(row.name, is_set ? blue : ImGui::GetStyleColorVec4(ImGuiCol_Text));
  std::string value = is_list ? choose(row, options) : write(row, options);
  const bool is_hovered = end_row();
  ImGui::EndDisabled();
  if (is_hovered) show_help(row, is_idle ? reason->second : "");
  if (is_set) {
    ImGui::SameLine();
    if (ImGui::SmallButton("default")) value = "";
  }
  ImGui::PopID();
  return value == unchanged ? std::nullopt : std::optional(value);
}

bool OptionPanel::draw(Options& options, const sideray_scene_facts& facts, std::string& message) {
  find_reasons(options, facts);
  std::optional<Change> change;
  for (const std::string& group : titles_of_groups()) {
    const std::vector<const sideray_option*> rows = rows_of(group);
    if (rows.empty() || (group != most_used && !draw_title(group, rows, options))) continue;
    for (const sideray_option* row : rows)
      if (const auto value = draw_row(*row, options)) change = {row->name, *value};
  }
  return change && apply(*change, options, message);
}

}  // namespace sideray::viewer
