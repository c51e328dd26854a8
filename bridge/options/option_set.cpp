#include "bridge/options/option_set.h"

#include "model/failure.h"

namespace sideray::bridge {
namespace {

void check_beside_reference(const OptionRow& row, const OptionValue& value) {
  if (!row.beside_reference || value.text == row.beside_reference) return;
  fail(SIDERAY_INVALID_ARGUMENT, "reference: contradicts '{}', which it decides itself; leave one of them out",
       row.option.name);
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
  for (size_t i = 0; i < table.size(); ++i) {
    const std::string by_default = table[i].option.default_value;
    if (!table[i].store || (!given_[i] && by_default.empty())) continue;
    table[i].store(v, given_[i] ? *given_[i] : parse_option(table[i], by_default));
  }
  v.translucency.layers = v.surfaces.value_or(default_surfaces(v.translucency.method));
  values_ = v;
  values_.picture.translucency = &values_.translucency;
  values_.picture.shadows = &values_.shadows;
  values_.picture.poses = &values_.poses;
  values_.picture.filters = v.filters_results ? &values_.filters : nullptr;
  values_.picture.reference = v.is_reference ? &values_.reference : nullptr;
  texts_.assign(table.size(), "");
  for (size_t i = 0; i < table.size(); ++i) {
    texts_[i] = given_[i] ? given_[i]->text : table[i].option.default_value;
    if (table[i].decided) texts_[i] = table[i].decided(values_, texts_[i]);
  }
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

void OptionSet::check() const {
  const std::vector<OptionRow>& table = option_table();
  for (size_t i = 0; values_.is_reference && i < table.size(); ++i)
    if (given_[i]) check_beside_reference(table[i], *given_[i]);
  for (size_t i = 0; i < table.size(); ++i)
    if (given_[i] && table[i].check) table[i].check(values_, *given_[i]);
}

}  // namespace sideray::bridge
