// Options as tables: one entry a long option, read from the command line or from JSON into the text that was given.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sideray::cli {

struct Option {
  enum class Kind { value, choice, flag };
  std::string name;  // without dashes; one letter: a short option
  Kind kind = Kind::value;
  std::string placeholder;          // value: "WxH"
  std::vector<std::string> values;  // choice
  std::string used;                 // the value used where none is given; "" = none
  bool in_config = true;            // printed in the stats
  std::string help;
};

using Given = std::map<std::string, std::string>;  // option name -> text; flags hold "true"

void add_options(CLI::App& command, std::span<const Option> options, Given& given);

// Refuses unknown options and unknown choices. Throws UsageError.
void check_given(std::span<const Option> options, const Given& given);

// The text given, else the value used where none is given.
std::string text_of(std::span<const Option> options, const Given& given, const std::string& name);

// Throws UsageError naming the option and the accepted range.
double number(const std::string& name, const std::string& text, double low, double high);
uint32_t whole_number(const std::string& name, const std::string& text, uint32_t low, uint32_t high);
std::vector<std::string> split(const std::string& text, char separator);

}  // namespace sideray::cli
