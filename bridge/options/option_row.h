// Describes one row of the option table: its public part, and what the library does with it. Any thread.
#pragma once

#include <sideray/options.h>
#include <sideray/plan.h>

#include <string>
#include <type_traits>
#include <vector>

#include "bridge/options/option_values.h"

namespace sideray::bridge {

// Holds a parsed value.
struct OptionValue {
  std::string text;
  // The number of a choice or word by its row; of a switch or flag, 0 or 1; otherwise the value itself.
  double number = 0;
  uint32_t width = 0, height = 0;  // only of a size
  bool is_word = false;

  bool on() const { return number != 0; }
  uint32_t whole() const { return static_cast<uint32_t>(number); }
};

struct OptionWord {
  const char* word;
  int64_t value;
};

// Holds the facts of the scene that options depend on.
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
  sideray_option option{};          // its choices point into `choices` once it is in the table
  std::vector<OptionWord> words;    // choices, or words beside numbers
  std::vector<const char*> choices;  // the same words for the public struct
  const char* range = "";           // in words, where it is not minimum to maximum

  // Write a value to its field, and read it. nullptr: there is no field, or the value is no number.
  void (*store)(OptionValues&, const OptionValue&) = nullptr;
  double (*load)(const OptionValues&) = nullptr;
  // Returns why the current way of drawing does not read the option, which statistics then omit; nullptr: it does.
  const char* (*unread)(const OptionValues&) = nullptr;
  // Returns why the option makes no difference although it is read; nullptr: it may make one.
  const char* (*idle)(const OptionValues&) = nullptr;
  // Returns an equivalent value for the scene; "" = the default. nullptr: the row has none.
  std::string (*settled)(const OptionValues&, const OptionScene&, const std::string& text) = nullptr;
  // Returns how the value makes pictures depend on earlier ones; nullptr: it does not.
  sideray_past (*past)(const OptionValues&) = nullptr;
  // Adds the shortcut of values other than the exact one, whether taken or not; nullptr: there is none.
  void (*shortcuts)(const OptionValues&, const OptionScene&, std::vector<Shortcut>&) = nullptr;
  // Throws Failure where the value contradicts other options. Public structs have a value for every option and are not
  // checked for contradictions (the option is then ignored), unless `checks_structs`.
  void (*check)(const OptionValues&, const OptionValue&) = nullptr;
  bool checks_structs = false;
  // Values that only the public structs accept, since the command line has no word for them.
  std::vector<double> in_structs = {};
  // Whether it only selects random numbers.
  bool is_random = false;
  // Returns the value in effect if the option is not set, or if another option overrules it.
  std::string (*decided)(const OptionValues&, const std::string& text) = nullptr;
  // The only value allowed together with `reference`, which decides the option itself: "" = none, nullptr = all.
  const char* beside_reference = nullptr;
};

struct NumberRange {
  double minimum, maximum;
};

// Return rows of each type.
OptionRow option_switch(const char* name, const char* default_value, const char* help);
OptionRow option_flag(const char* name, const char* help);
OptionRow option_choice(const char* name, std::vector<OptionWord> words, const char* default_value, const char* help);
OptionRow option_number(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                        const char* help);
OptionRow option_integer(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                         const char* help);
OptionRow option_text(const char* name, const char* placeholder, const char* default_value, const char* help);

// The title of the options for most pictures, first in the help.
constexpr const char* most_used = "Most used";

// Sets the title of rows that have none; diagnostics have their own.
std::vector<OptionRow> under_title(const char* group, std::vector<OptionRow> rows);

// Connects a row to a field of one of the structs.
template <auto part, auto field>
void bind(OptionRow& row) {
  row.store = [](OptionValues& v, const OptionValue& value) {
    using Field = std::remove_reference_t<decltype((v.*part).*field)>;
    (v.*part).*field = static_cast<Field>(value.number);
  };
  row.load = [](const OptionValues& v) { return static_cast<double>((v.*part).*field); };
}

// Return the parts of the table, each in the order of docs/cli.md.
std::vector<OptionRow> leading_rows();
std::vector<OptionRow> translucency_rows();
std::vector<OptionRow> shadow_rows();
std::vector<OptionRow> sampling_rows();

// Returns the number of surfaces of a ray if `layers` is not set.
uint32_t default_surfaces(const OptionValues& values);

// Returns the whole table, which is never destroyed.
const std::vector<OptionRow>& option_table();
// Returns the row's place in the table, or the number of rows where no row has that name.
size_t option_place(const char* name);

// Throws Failure (INVALID_ARGUMENT) that names the option and what it accepts.
OptionValue parse_option(const OptionRow& row, const std::string& text);
// Returns the value in the structs of a row with `load`. Throws Failure as parse_option() does.
OptionValue read_option(const OptionRow& row, const OptionValues& values);

// Throws Failure (INVALID_ARGUMENT) where a side or the number of pixels is too large.
void check_size(uint32_t width, uint32_t height);

}  // namespace sideray::bridge
