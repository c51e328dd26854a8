#include "cli/options/options.h"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "cli/base/failure.h"
#include "cli/base/near_name.h"

namespace sideray::cli {
namespace {

constexpr size_t help_column = 28;  // where texts begin, so that they end before column 100

bool is_choice(const sideray_option& option) {
  return option.type == SIDERAY_OPTION_CHOICE || option.type == SIDERAY_OPTION_SWITCH;
}

std::span<const char* const> choices_of(const sideray_option& option) {
  return {option.choices, option.choice_count};
}

void check_choice(const sideray_option& option, const std::string& text) {
  const std::span<const char* const> choices = choices_of(option);
  if (const char* instead = sideray_option_removed(option.name, text.c_str()))
    wrong_usage("{}: \"{}\" is gone since 0.3; {}", dashed(option.name), text, instead);
  if (std::find(choices.begin(), choices.end(), text) == choices.end())
    wrong_usage("{}: unknown value \"{}\"; one of {}", dashed(option.name), text, fmt::join(choices, ", "));
}

const sideray_option& row_of(const Table& table, const std::string& name) {
  if (const sideray_option* option = find(table, name)) return *option;
  const std::string instead = instead_of(name);
  if (!instead.empty()) wrong_usage("{}: is gone since 0.3; {}", dashed(name), instead);
  std::vector<std::string> names;
  for (const sideray_option* row : table) names.push_back(row->name);
  const std::string near = near_name(name, names);
  wrong_usage("{}: no such option; {}see sideray render --help", dashed(name), did_you_mean(near.empty() ? "" : dashed(near)));
}

bool is_diagnostic(const std::string& name) {
  const sideray_option* option = sideray_option_find(name.c_str());
  return option && option->diagnostic;
}

std::string help_of(const sideray_option& option) {
  return *option.default_value && option.type != SIDERAY_OPTION_FLAG
             ? fmt::format("{} [{}]", option.help, option.default_value)
             : option.help;
}

Table diagnostics_of(const Table& table) {
  Table rows;
  std::copy_if(table.begin(), table.end(), std::back_inserter(rows),
               [](const sideray_option* option) { return option->diagnostic != 0; });
  return rows;
}

std::string names_of(const Table& table) {
  std::vector<std::string> names;
  for (const sideray_option* option : table) names.emplace_back(option->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

void print_diagnostics(const Table& rows) {
  for (const sideray_option* row : rows) {
    const std::string values = row->type == SIDERAY_OPTION_FLAG ? "true" : values_of(*row);
    fmt::print("{:<36} {}\n", fmt::format("{}={}", row->name, values), help_of(*row));
  }
}

// Reads "NAME=VALUE", or only the name of a flag.
void give_diagnostic(const Table& rows, const std::string& text, Given& given) {
  const size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const sideray_option* row = find(rows, name);
  if (!row) wrong_usage("--diagnose: unknown name \"{}\"; one of {}", name, names_of(rows));
  const bool is_flag = row->type == SIDERAY_OPTION_FLAG;
  if (equals == std::string::npos && !is_flag)
    wrong_usage("--diagnose {}: has no value; write {}={}", name, name, values_of(*row));
  const std::string value = equals == std::string::npos ? "true" : text.substr(equals + 1);
  if (is_flag && value != "true" && value != "false")
    wrong_usage("--diagnose {}: unknown value \"{}\"; give true or false", name, value);
  if (is_choice(*row)) check_choice(*row, value);
  if (given.contains(name)) wrong_usage("--diagnose: {} is given twice; leave one of them out", name);
  if (!is_flag || value == "true") given[name] = value;
}

void add_diagnostics(CLI::App& command, const Table& rows, Given& given) {
  const auto read = [rows, &given](const std::vector<std::string>& texts) {
    for (const std::string& text : texts)
      for (const std::string& part : split(text, ',')) {
        if (part != "help" && part != "list") {
          give_diagnostic(rows, part, given);
          continue;
        }
        print_diagnostics(rows);
        throw CLI::Success();
      }
  };
  command
      .add_option_function<std::vector<std::string>>("--diagnose", read,
                                                     "comparators and checks; --diagnose help lists them")
      ->type_name("NAME=VALUE,...")
      ->allow_extra_args(false)
      ->group("Diagnostics");
}

// Accepts options of pictures of version 0.2 that have no effect any more: without a row, and not in the help.
void add_without_effect(CLI::App& command, Given& given) {
  const std::string name = "shading-reuse";
  command.add_option_function<std::string>(dashed(name), [&given, name](const std::string& text) { give(given, name, text); })
      ->group("");
}

// Adds --help-all, which gives `rare` options, hidden in the short help, their titles.
void add_long_help(CLI::App& command, std::vector<std::pair<CLI::Option*, std::string>> rare) {
  if (rare.empty()) return;
  command.add_flag_callback(
      "--help-all",
      [rare] {
        for (const auto& [option, group] : rare) option->group(group);
        throw CLI::CallForHelp();
      },
      fmt::format("prints {} more options too and exits", rare.size()));
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
  row.group = "Options";
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

std::string values_of(const sideray_option& option) {
  return is_choice(option) ? fmt::format("{}", fmt::join(choices_of(option), "|")) : option.placeholder;
}

std::string dashed(const std::string& name) {
  if (is_diagnostic(name)) return "--diagnose " + name;
  return (name.size() == 1 ? "-" : "--") + name;
}

std::string dashed(const std::string& name, const std::string& value) {
  return dashed(name) + (is_diagnostic(name) ? '=' : ' ') + value;
}

void give(Given& given, const std::string& name, const std::string& text) {
  const char* now = sideray_option_read_as(name.c_str(), text.c_str());
  if (now && !*now)
    return print_warning(fmt::format("{}: has no effect since 0.3 and is refused from 0.4 on; leave it out", dashed(name)));
  if (now)
    print_warning(fmt::format("{}: is read as {} since 0.3 and refused from 0.4 on", dashed(name, text), now));
  given[name] = now ? now : text;
}

std::string instead_of(const std::string& name) {
  static const std::map<std::string, std::string> of_program{
      {"repeat", "use sideray bench SCENE --repeat N"},
      {"raw-frame", "use sideray bench SCENE"},
      {"map", "use sideray compare IMAGE REFERENCE --map FILE.png"},
      {"fail-above", "use sideray compare IMAGE REFERENCE --fail-above X"},
      {"fail-below", "use sideray compare IMAGE REFERENCE --fail-below X"},
      {"metric", "use sideray compare IMAGE REFERENCE --metric NAME"},
      {"json", "use sideray compare IMAGE REFERENCE --json"}};
  if (const char* instead = sideray_option_removed(name.c_str(), nullptr)) return instead;
  if (is_diagnostic(name)) {
    const sideray_option& row = *sideray_option_find(name.c_str());
    const bool is_flag = row.type == SIDERAY_OPTION_FLAG;
    return fmt::format("write --diagnose {}={}", name, is_flag ? "true" : values_of(row));
  }
  const auto at = of_program.find(name);
  return at == of_program.end() ? "" : at->second;
}

const sideray_option* find(const Table& table, const std::string& name) {
  const auto at = std::find_if(table.begin(), table.end(), [&](const sideray_option* o) { return o->name == name; });
  return at == table.end() ? nullptr : *at;
}

void add_options(CLI::App& command, const Table& table, Given& given) {
  command.get_formatter()->column_width(help_column);
  std::vector<std::pair<CLI::Option*, std::string>> rare;
  for (const sideray_option* row : table) {
    if (row->diagnostic) continue;
    const std::string name = row->name;
    CLI::Option* option = nullptr;
    if (row->type == SIDERAY_OPTION_FLAG)
      option = command.add_flag_callback(dashed(name), [&given, name] { given[name] = "true"; }, help_of(*row));
    else
      option = command
                   .add_option_function<std::string>(
                       dashed(name), [&given, name](const std::string& text) { give(given, name, text); }, help_of(*row))
                   ->type_name(values_of(*row));
    option->group(row->advanced ? "" : row->group);
    if (row->advanced) rare.emplace_back(option, row->group);
  }
  if (const Table diagnostics = diagnostics_of(table); !diagnostics.empty())
    add_diagnostics(command, diagnostics, given);
  if (find(table, "cache-rate")) add_without_effect(command, given);
  add_long_help(command, std::move(rare));
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
    wrong_usage("{}: \"{}\" is not a number; give {} to {}", dashed(name), text, low, high);
  if (value < low || value > high) wrong_usage("{}: {} is out of range; give {} to {}", dashed(name), text, low, high);
  return value;
}

uint32_t whole_number(const std::string& name, const std::string& text, uint32_t low, uint32_t high) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size())
    wrong_usage("{}: \"{}\" is not a whole number; give {} to {}", dashed(name), text, low, high);
  if (error != std::errc() || value < low || value > high)
    wrong_usage("{}: {} is out of range; give {} to {}", dashed(name), text, low, high);
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
