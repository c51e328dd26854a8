#include "cli/options/options.h"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cli/base/failure.h"

namespace sideray::cli {
namespace {

std::string dashed(const std::string& name) {
  return (name.size() == 1 ? "-" : "--") + name;
}

const Option* find(std::span<const Option> options, const std::string& name) {
  const auto at = std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == name; });
  return at == options.end() ? nullptr : &*at;
}

bool contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

void check_choice(const Option& option, const std::string& text) {
  if (!contains(option.values, text))
    wrong_usage("--{}: unknown value \"{}\"; one of {}", option.name, text, fmt::join(option.values, ", "));
}

}  // namespace

void add_options(CLI::App& command, std::span<const Option> options, Given& given) {
  for (const Option& option : options) {
    std::string help = option.help;
    if (option.kind == Option::Kind::flag) {
      command.add_flag_callback(
          dashed(option.name), [&given, name = option.name] { given[name] = "true"; }, help);
      continue;
    }
    if (!option.used.empty()) help += fmt::format(" [{}]", option.used);
    command
        .add_option_function<std::string>(
            dashed(option.name), [&given, name = option.name](const std::string& text) { given[name] = text; }, help)
        ->type_name(option.kind == Option::Kind::choice ? fmt::format("{}", fmt::join(option.values, "|"))
                                                        : option.placeholder);
  }
}

void check_given(std::span<const Option> options, const Given& given) {
  for (const auto& [name, text] : given) {
    const Option* option = find(options, name);
    if (!option) wrong_usage("{}: no such option; see sideray render --help", dashed(name));
    if (text.empty()) wrong_usage("{}: is empty; give a value or leave it out", dashed(name));
    if (option->kind == Option::Kind::choice) check_choice(*option, text);
  }
}

std::string text_of(std::span<const Option> options, const Given& given, const std::string& name) {
  if (const auto at = given.find(name); at != given.end()) return at->second;
  const Option* option = find(options, name);
  return option ? option->used : std::string();
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
