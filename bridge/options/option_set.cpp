#include "bridge/options/option_set.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

void check_beside_reference(const OptionRow& row, const OptionValue& value) {
  if (!row.beside_reference || value.text == row.beside_reference) return;
  fail(SIDERAY_INVALID_ARGUMENT, "reference: contradicts '{}', which it decides itself; leave one of them out",
       row.option.name);
}

// Returns the value of an option that is not given; it may depend on the rows before it.
std::string default_of(const OptionRow& row, const OptionValues& before) {
  const char* preset = preset_value(before.quality, row.option.name, before);
  return preset ? preset : row.option.default_value;
}

// Returns whether the scene has nothing that options of the row's part affect.
bool has_no_use(const OptionRow& row, const OptionScene& scene) {
  const std::string_view part = row.option.part;
  return (part == "translucency" && !scene.has_translucency()) ||
         (part == "shadows" && scene.facts.lit_lights == 0);
}

}  // namespace

OptionSet::OptionSet() : given_(option_table().size()) {
  resolve();
}

OptionSet::OptionSet(const OptionSet& other) : given_(other.given_) {
  resolve();
}

void OptionSet::set(size_t place, const std::string& text) {
  if (text.empty())
    given_[place].reset();
  else
    given_[place] = parse_option(option_table()[place], text);
  resolve();
}

void OptionSet::resolve() {
  const std::vector<OptionRow>& table = option_table();
  OptionValues v;
  // A row's default depends on those that come before it.
  std::vector<std::string> texts;
  for (size_t i = 0; i < table.size(); ++i) {
    texts.push_back(given_[i] ? given_[i]->text : default_of(table[i], v));
    if (!table[i].store || texts[i].empty()) continue;
    table[i].store(v, given_[i] ? *given_[i] : parse_option(table[i], texts[i]));
  }
  v.translucency.layers = v.surfaces.value_or(default_surfaces(v));
  values_ = v;
  values_.picture.translucency = &values_.translucency;
  values_.picture.shadows = &values_.shadows;
  values_.picture.poses = &values_.poses;
  values_.picture.reference = v.is_reference ? &values_.reference : nullptr;
  texts_ = std::move(texts);
  for (size_t i = 0; i < table.size(); ++i)
    if (table[i].decided) texts_[i] = table[i].decided(values_, texts_[i]);
}

const char* OptionSet::unread(size_t place) const {
  const OptionRow& row = option_table()[place];
  return row.unread ? row.unread(values_) : nullptr;
}

const char* OptionSet::idle(size_t place) const {
  const OptionRow& row = option_table()[place];
  if (const char* reason = unread(place)) return reason;
  if (values_.is_reference && row.beside_reference && !*row.beside_reference) return "a reference decides it";
  return row.idle ? row.idle(values_) : nullptr;
}

void OptionSet::reduce(const sideray_scene_facts& facts) {
  const std::vector<OptionRow>& table = option_table();
  bool changes = true;
  // Repeats until nothing changes, since a row may depend on rows behind it.
  while (changes) {
    changes = false;
    for (size_t i = 0; i < table.size(); ++i) {
      std::string text = texts_[i];
      if (table[i].settled) text = table[i].settled(values_, {facts}, text);
      if (idle(i) || has_no_use(table[i], {facts})) text.clear();
      if (text == texts_[i] || (text.empty() && !given_[i])) continue;
      set(i, text);
      changes = true;
    }
  }
}

sideray_past OptionSet::past() const {
  sideray_past most = SIDERAY_PAST_NONE;
  for (const OptionRow& row : option_table())
    if (row.past) most = std::max(most, row.past(values_));
  return most;
}

std::vector<Shortcut> OptionSet::shortcuts(const sideray_scene_facts& facts) const {
  std::vector<Shortcut> list;
  for (const OptionRow& row : option_table())
    if (row.shortcuts) row.shortcuts(values_, {facts}, list);
  return list;
}

void OptionSet::check() const {
  const std::vector<OptionRow>& table = option_table();
  for (size_t i = 0; values_.is_reference && i < table.size(); ++i)
    if (given_[i]) check_beside_reference(table[i], *given_[i]);
  for (size_t i = 0; i < table.size(); ++i)
    if (given_[i] && table[i].check) table[i].check(values_, *given_[i]);
}

}  // namespace sideray::bridge
