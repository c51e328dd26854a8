#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/ranges.h>

#include "bridge/options/option_row.h"
#include "bridge/options/removed_options.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint64_t most_pixels = uint64_t{1} << 26;
constexpr uint32_t longest_side = 16384;

OptionRow row_of(const char* name, sideray_option_type type, const char* default_value, const char* help) {
  OptionRow row;
  row.option.name = name;
  row.option.type = type;
  row.option.placeholder = "";
  row.option.default_value = default_value;
  row.option.help = help;
  return row;
}

// Sets texts of the public struct that the row leaves out to "".
void fill_in(OptionRow& row) {
  for (const char** text : {&row.option.part, &row.option.placeholder, &row.option.default_value, &row.option.applies,
                            &row.option.exact_value, &row.option.help, &row.option.group})
    if (!*text) *text = "";
  for (const OptionWord& word : row.words) row.choices.push_back(word.word);
  row.option.choices = row.choices.data();
  row.option.choice_count = row.choices.size();
}

std::vector<OptionRow> made_table() {
  std::vector<OptionRow> table;
  for (auto* rows : {leading_rows, translucency_rows, shadow_rows, sampling_rows})
    for (OptionRow& row : rows()) table.push_back(std::move(row));
  for (OptionRow& row : table) fill_in(row);
  return table;
}

std::string range_of(const OptionRow& row) {
  if (*row.range) return row.range;
  return fmt::format("{} to {}", row.option.minimum, row.option.maximum);
}

double parse_number(const OptionRow& row, const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value))
    fail(SIDERAY_INVALID_ARGUMENT, "{}: \"{}\" is not a number; give {}", row.option.name, text, range_of(row));
  if (value < row.option.minimum || value > row.option.maximum)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: {} is out of range; give {}", row.option.name, text, range_of(row));
  return value;
}

double parse_integer(const OptionRow& row, const std::string& text) {
  uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc::invalid_argument || stop != end)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: \"{}\" is not a whole number; give {}", row.option.name, text, range_of(row));
  const auto number = static_cast<double>(value);
  if (error != std::errc() || number < row.option.minimum || number > row.option.maximum)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: {} is out of range; give {}", row.option.name, text, range_of(row));
  return number;
}

void parse_size(const OptionRow& row, OptionValue& value) {
  const size_t cross = value.text.find('x');
  const bool is_pair = cross != std::string::npos && cross > 0 && cross + 1 < value.text.size() &&
                       value.text.find('x', cross + 1) == std::string::npos;
  if (!is_pair)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: \"{}\" is not WIDTHxHEIGHT; write for example 1280x720", row.option.name,
         value.text);
  value.width = static_cast<uint32_t>(parse_integer(row, value.text.substr(0, cross)));
  value.height = static_cast<uint32_t>(parse_integer(row, value.text.substr(cross + 1)));
  check_size(value.width, value.height);
}

double parse_flag(const OptionRow& row, const std::string& text) {
  if (text != "true" && text != "false")
    fail(SIDERAY_INVALID_ARGUMENT, "{}: unknown value \"{}\"; give true or false", row.option.name, text);
  return text == "true";
}

}  // namespace

OptionRow option_switch(const char* name, const char* default_value, const char* help) {
  OptionRow row = row_of(name, SIDERAY_OPTION_SWITCH, default_value, help);
  row.words = {{"on", 1}, {"off", 0}};
  return row;
}

OptionRow option_flag(const char* name, const char* help) {
  return row_of(name, SIDERAY_OPTION_FLAG, "false", help);
}

OptionRow option_choice(const char* name, std::vector<OptionWord> words, const char* default_value, const char* help) {
  OptionRow row = row_of(name, SIDERAY_OPTION_CHOICE, default_value, help);
  row.words = std::move(words);
  return row;
}

OptionRow option_number(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                        const char* help) {
  OptionRow row = row_of(name, SIDERAY_OPTION_NUMBER, default_value, help);
  row.option.placeholder = placeholder;
  row.option.minimum = range.minimum;
  row.option.maximum = range.maximum;
  return row;
}

OptionRow option_integer(const char* name, const char* placeholder, NumberRange range, const char* default_value,
                         const char* help) {
  OptionRow row = option_number(name, placeholder, range, default_value, help);
  row.option.type = SIDERAY_OPTION_INTEGER;
  return row;
}

OptionRow option_text(const char* name, const char* placeholder, const char* default_value, const char* help) {
  OptionRow row = row_of(name, SIDERAY_OPTION_TEXT, default_value, help);
  row.option.placeholder = placeholder;
  return row;
}

std::vector<OptionRow> under_title(const char* group, std::vector<OptionRow> rows) {
  for (OptionRow& row : rows)
    if (!row.option.group) row.option.group = row.option.diagnostic ? "Diagnostics" : group;
  return rows;
}

const std::vector<OptionRow>& option_table() {
  static const std::vector<OptionRow> table = made_table();
  return table;
}

size_t option_place(const char* name) {
  const std::vector<OptionRow>& table = option_table();
  const auto at = std::find_if(table.begin(), table.end(),
                               [&](const OptionRow& row) { return std::string_view(row.option.name) == name; });
  return static_cast<size_t>(at - table.begin());
}

OptionValue parse_option(const OptionRow& row, const std::string& text) {
  OptionValue value;
  value.text = text;
  const auto word =
      std::find_if(row.words.begin(), row.words.end(), [&](const OptionWord& w) { return text == w.word; });
  if (word != row.words.end()) {
    value.is_word = true;
    value.number = static_cast<double>(word->value);
    return value;
  }
  switch (row.option.type) {
    case SIDERAY_OPTION_SWITCH:
    case SIDERAY_OPTION_CHOICE:
      if (const char* instead = removed_value(row.option.name, text))
        fail(SIDERAY_INVALID_ARGUMENT, "{}: \"{}\" is gone since 0.3; {}", row.option.name, text, instead);
      fail(SIDERAY_INVALID_ARGUMENT, "{}: unknown value \"{}\"; one of {}", row.option.name, text,
           fmt::join(row.choices, ", "));
    case SIDERAY_OPTION_FLAG:
      value.number = parse_flag(row, text);
      break;
    case SIDERAY_OPTION_INTEGER:
      value.number = parse_integer(row, text);
      break;
    case SIDERAY_OPTION_NUMBER:
      value.number = parse_number(row, text);
      break;
    case SIDERAY_OPTION_SIZE:
      parse_size(row, value);
      break;
    default:
      break;
  }
  return value;
}

OptionValue read_option(const OptionRow& row, const OptionValues& values) {
  OptionValue value;
  value.number = row.load(values);
  value.text = fmt::format("{}", value.number);
  value.is_word = std::any_of(row.words.begin(), row.words.end(), [&](const OptionWord& word) {
    return static_cast<double>(word.value) == value.number;
  });
  if (value.is_word || row.option.type == SIDERAY_OPTION_SWITCH || row.option.type == SIDERAY_OPTION_FLAG) return value;
  if (std::find(row.in_structs.begin(), row.in_structs.end(), value.number) != row.in_structs.end()) return value;
  if (row.option.type == SIDERAY_OPTION_CHOICE)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: no value of it has the number {}; it has {}", row.option.name, value.text,
         fmt::join(row.choices, ", "));
  if (!(value.number >= row.option.minimum && value.number <= row.option.maximum))
    fail(SIDERAY_INVALID_ARGUMENT, "{}: {} is out of range; give {}", row.option.name, value.text, range_of(row));
  return value;
}

void check_size(uint32_t width, uint32_t height) {
  if (width < 1 || height < 1 || width > longest_side || height > longest_side ||
      uint64_t{width} * height > most_pixels)
    fail(SIDERAY_INVALID_ARGUMENT, "size: {}x{}: is out of range; give sides of 1 to {} and at most {} pixels in all",
         width, height, longest_side, most_pixels);
}

}  // namespace sideray::bridge
