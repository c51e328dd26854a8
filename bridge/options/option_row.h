// One row of the table of options: what is public of it, and what the library does with it. Any thread.
#pragma once

#include <sideray/options.h>
#include <sideray/plan.h>

#include <string>
#include <type_traits>
#include <vector>

#include "bridge/options/option_values.h"

namespace sideray::bridge {

// A value as its row understands it.
struct OptionValue {
  std::string text;
  // Of a choice or a word beside numbers what the row says of it, of a switch or flag 0 or 1, else the number.
  double number = 0;
  uint32_t width = 0, height = 0;  // of a size
  bool is_word = false;

  bool on() const { return number != 0; }
  uint32_t whole() const { return static_cast<uint32_t>(number); }
};

struct OptionWord {
  const char* word;
  int64_t value;
};

// The scene as far as options depend on it.
struct OptionScene {
  const sideray_scene_facts& facts;
  bool has_translucency() const { return facts.translucent_objects > 0 || facts.sprites > 0; }
};

struct Shortcut {
  std::string name;
  bool taken;
  std::string text;
  std::vector<sideray_option_value> exactly = {};
  bool is_random = false;
};

struct OptionRow {
  sideray_option option{};          // its choices point into `choices`, once it is in the table
  std::vector<OptionWord> words;    // choices, or words beside numbers
  std::vector<const char*> choices;  // the same as the public struct has them
  const char* range = "";           // in words, where it is not minimum to maximum

  // Writes a value to its field, and reads it from there. nullptr: it has no field, or is no number.
  void (*store)(OptionValues&, const OptionValue&) = nullptr;
  double (*load)(const OptionValues&) = nullptr;
  // Why the way of drawing does not read the option; nullptr where it does. Statistics leave it out then.
  const char* (*unread)(const OptionValues&) = nullptr;
  // Why it makes no difference although it is read; nullptr where it may make one.
  const char* (*idle)(const OptionValues&) = nullptr;
  // An equivalent value for the scene, if there is one; "" = the default. nullptr: there is none.
  std::string (*settled)(const OptionValues&, const OptionScene&, const std::string& text) = nullptr;
  // How the value makes pictures depend on those before them; nullptr: it does not.
  sideray_past (*past)(const OptionValues&) = nullptr;
  // Adds the shortcut that a value other than the exact one means, taken or not; nullptr: there is none.
  void (*shortcuts)(const OptionValues&, const OptionScene&, std::vector<Shortcut>&) = nullptr;
  // Throws Failure where the value contradicts other options. A public struct has a value for every option and is not
  // checked for contradictions (the option is then ignored), unless `checks_structs`.
  void (*check)(const OptionValues&, const OptionValue&) = nullptr;
  bool checks_structs = false;
  // Values that only the public structs accept: the command line has no word for them.
  std::vector<double> in_structs = {};
  // It says which random numbers are drawn, and nothing else.
  bool is_random = false;
  // The value in effect if the option is not set, or if another option overrules it.
  std::string (*decided)(const OptionValues&, const std::string& text) = nullptr;
  // The one value that may be said beside `reference`, which decides the option itself: "" = none, nullptr = all.
  const char* beside_reference = nullptr;
};

struct NumberRange {
  double minimum, maximum;
};

// Rows of each type.
OptionRow option_switch(const char* name, const char* default_value, const char* help);
OptionRow option_flag(const char* name, const char* help);
OptionRow option_choice(const char* name, std::vector<OptionWord> words, const char* default_value, const char* help);
OptionRow option_number(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                        const char* help);
OptionRow option_integer(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                         const char* help);
OptionRow option_text(const char* name, const char* placeholder, const char* default_value, const char* help);

// The title of the options that most pictures need, first in the help.
constexpr const char* most_used = "Most used";

// Gives the rows a title where they have none; diagnostics have their own.
std::vector<OptionRow> under_title(const char* group, std::vector<OptionRow> rows);

// Ties a row to a field of one of the structs.
template <auto part, auto field>
void bind(OptionRow& row) {
  row.store = [](OptionValues& v, const OptionValue& value) {
    using Field = std::remove_reference_t<decltype((v.*part).*field)>;
    (v.*part).*field = static_cast<Field>(value.number);
  };
  row.load = [](const OptionValues& v) { return static_cast<double>((v.*part).*field); };
}

// The parts of the table, each in the order of docs/cli.md.
std::vector<OptionRow> leading_rows();
std::vector<OptionRow> translucency_rows();
std::vector<OptionRow> shadow_rows();
std::vector<OptionRow> sampling_rows();

// The surfaces of a ray where `layers` says nothing.
uint32_t default_surfaces(const OptionValues& values);

// The whole table. It lives for ever.
const std::vector<OptionRow>& option_table();
// The row's place in the table; the number of rows where there is none of that name.
size_t option_place(const char* name);

// Throws Failure (INVALID_ARGUMENT) that names the option and what it accepts.
OptionValue parse_option(const OptionRow& row, const std::string& text);
// Returns the value that the structs have for a row with `load`. Throws Failure as parse_option() does.
OptionValue read_option(const OptionRow& row, const OptionValues& values);

// Throws Failure (INVALID_ARGUMENT) where a side or all pixels are too many.
void check_size(uint32_t width, uint32_t height);

}  // namespace sideray::bridge
