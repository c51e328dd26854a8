// Reads options by their table, one row an option, from the command line or from JSON into the texts that were given.
// Any thread.
#pragma once

#include <sideray/options.h>

#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sideray::cli {

// Rows of the library's table and of the program's own, in the order of --help. Names have no dashes; one letter is a
// short option.
using Table = std::vector<const sideray_option*>;
using Given = std::map<std::string, std::string>;  // option name -> text; flags hold "true"

// Rows of the program's own. Their texts live for ever.
sideray_option text_row(const char* name, const char* placeholder, const char* default_value, const char* help);
sideray_option number_row(sideray_option row, double minimum, double maximum);
sideray_option flag_row(const char* name, const char* help);

// Adds the table's rows under their titles, --diagnose for those that are diagnostics, and --help-all where the help
// leaves rows out. Parsing throws UsageError for diagnostics that are wrong; `--diagnose help` prints them and ends the
// program.
void add_options(CLI::App& command, const Table& table, Given& given);

// What help and the manual show behind the name: "N|auto|unlimited", "on|off"; "" for flags.
std::string values_of(const sideray_option& option);

// "--layers", "-o", "--diagnose match"; with a value "--layers 2", "--diagnose match=distance".
std::string dashed(const std::string& name);
std::string dashed(const std::string& name, const std::string& value);
// Gives an option a text. What 0.2 had and is still read as something else is given as that, with a warning.
void give(Given& given, const std::string& name, const std::string& text);
// Returns what to write instead of an option that 0.2 had and the command has not; "" where 0.2 had none of that name.
std::string instead_of(const std::string& name);
// NULL where the table has no such row.
const sideray_option* find(const Table& table, const std::string& name);

// Refuses unknown options, empty values and unknown choices. Throws UsageError.
void check_given(const Table& table, const Given& given);

// The text given, else the default.
std::string text_of(const Table& table, const Given& given, const std::string& name);

// Throws UsageError naming the option and the accepted range.
double number(const std::string& name, const std::string& text, double low, double high);
uint32_t whole_number(const std::string& name, const std::string& text, uint32_t low, uint32_t high);
// The same by the row's range, of the text given or the default.
double number_of(const Table& table, const Given& given, const std::string& name);
uint32_t whole_number_of(const Table& table, const Given& given, const std::string& name);

std::vector<std::string> split(const std::string& text, char separator);

}  // namespace sideray::cli
