#include "cli/options/options.h"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>

#include "cli/base/failure.h"

namespace sideray::cli {
namespace {

bool is_choice(const sideray_option& option) {
  return option.type == SIDERAY_OPTION_CHOICE || option.type == SIDERAY_OPTION_SWITCH;
}

std::span<const char* const> choices_of(const sideray_option& option) {
  return {option.choices, option.choice_count};
}

void check_choice(const sideray_option& option, const std::string& text) {
  const std::span<const char* const> choices = choices_of(option);
  if (const char* instead = sideray_option_removed(option.name, text.c_str()))
    wrong_usage("--{}: \"{}\" is gone since 0.3; {}", option.name, text, instead);
  if (std::find(choices.begin(), choices.end(), text) == choices.end())
    wrong_usage("--{}: unknown value \"{}\"; one of {}", option.name, text, fmt::join(choices, ", "));
}

const sideray_option& row_of(const Table& table, const std::string& name) {
  if (const sideray_option* option = find(table, name)) return *option;
  if (const char* instead = sideray_option_removed(name.c_str(), nullptr))
    wrong_usage("{}: is gone since 0.3; {}", dashed(name), instead);
  wrong_usage("{}: no such option; see sideray render --help", dashed(name));
}

}  // namespace

sideray_option text_row(const char* name, const char* placeholder, const char* default_value, const char* help) {
  sideray_option row{};
  row.name = name;
  row.part = "";
  row.type = SIDERAY_OPTION_TEXT;
  row.placeholder = placeholder;
  row.default_value = default_value;
  row.applies = "";
  row.exact_value = "";
  row.help = help;
  return row;
}

sideray_option number_row(sideray_option row, double minimum, double maximum) {
  row.type = SIDERAY_OPTION_NUMBER;
  row.minimum = minimum;
  row.maximum = maximum;
  return row;
}

sideray_option flag_row(const char* name, const char* help) {
  sideray_option row = text_row(name, "", "", help);
  row.type = SIDERAY_OPTION_FLAG;
  return row;
}

std::string dashed(const std::string& name) {
  return (name.size() == 1 ? "-" : "--") + name;
}

const sideray_option* find(const Table& table, const std::string& name) {
  const auto at = std::find_if(table.begin(), table.end(), [&](const sideray_option* o) { return o->name == name; });
  return at == table.end() ? nullptr : *at;
}

void add_options(CLI::App& command, const Table& table, Given& given) {
  for (const sideray_option* option : table) {
    const std::string name = option->name;
    std::string help = option->help;
    if (option->type == SIDERAY_OPTION_FLAG) {
      command.add_flag_callback(dashed(name), [&given, name] { given[name] = "true"; }, help);
      continue;
    }
    if (*option->default_value) help += fmt::format(" [{}]", option->default_value);
    command
        .add_option_function<std::string>(
            dashed(name), [&given, name](const std::string& text) { given[name] = text; }, help)
        ->type_name(is_choice(*option) ? fmt::format("{}", fmt::join(choices_of(*option), "|")) : option->placeholder);
  }
}

void check_given(const Table& table, const Given& given) {
  for (const auto& [name, text] : given) {
    const sideray_option& option = row_of(table, name);
    if (text.empty()) wrong_usage("{}: is empty; give a value or leave it out", dashed(name));
    if (is_choice(option)) check_choice(option, text);
  }
}

std::string text_of(const Table& table, const Given& given, const std::string& name) {
  if (const auto at = given.find(name); at != given.end()) return at->second;
  const sideray_option* option = find(table, name);
  return option ? option->default_value : "";
}

double number(const std::string& name, const std::string& text, double low, double high) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    wrong_usage("--{}: \"{}\" is not a number; give {} to {}", name, text, low, high);
  if (value < low || value > high) wrong_usage("--{}: {} is out of range; give {} to {}", name, text, low, high);
  return value;
}

uint32_t whole_number(const std::string& name, const std::string& text, uint32_t low, uint32_t high) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size())
    wrong_usage("--{}: \"{}\" is not a whole number; give {} to {}", name, text, low, high);
  if (error != std::errc() || value < low || value > high)
    wrong_usage("--{}: {} is out of range; give {} to {}", name, text, low, high);
  return static_cast<uint32_t>(value);
}

double number_of(const Table& table, const Given& given, const std::string& name) {
  const sideray_option& row = row_of(table, name);
  return number(name, text_of(table, given, name), row.minimum, row.maximum);
}

uint32_t whole_number_of(const Table& table, const Given& given, const std::string& name) {
  const sideray_option& row = row_of(table, name);
  return whole_number(name, text_of(table, given, name), static_cast<uint32_t>(row.minimum),
                      static_cast<uint32_t>(row.maximum));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (char c : text)
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

}  // namespace sideray::cli
