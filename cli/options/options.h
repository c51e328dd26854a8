// Reads options from the command line or from JSON by their table, which has a row for each, into texts. Any thread.
#pragma once

#include <sideray/options.h>

#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sideray::cli {

// Holds rows of the library's table and of the program's own, in the order of --help. Names have no dashes; one letter
// is a short option.
using Table = std::vector<const sideray_option*>;
using Given = std::map<std::string, std::string>;  // option name -> text; flags hold "true"

// Make rows of the program's own; their texts are never freed.
sideray_option text_row(const char* name, const char* placeholder, const char* default_value, const char* help);
sideray_option number_row(sideray_option row, double minimum, double maximum);
sideray_option flag_row(const char* name, const char* help);

// Adds the table's rows under their titles, --diagnose for diagnostics, and --help-all where the help omits rows.
// Parsing throws UsageError for wrong diagnostics; `--diagnose help` prints them and ends the program.
void add_options(CLI::App& command, const Table& table, Given& given);

// Returns the text for values behind the name in help and manual: "N|auto|unlimited", "on|off"; "" for flags.
std::string values_of(const sideray_option& option);

// Return "--layers", "-o", "--diagnose match"; with a value "--layers 2", "--diagnose match=distance".
std::string dashed(const std::string& name);
std::string dashed(const std::string& name, const std::string& value);
// Sets an option's text. An option of version 0.2 that is read as another one sets that, with a warning.
void give(Given& given, const std::string& name, const std::string& text);
// Returns the replacement of an option that only version 0.2 had; "" where it had none of that name.
std::string instead_of(const std::string& name);
// Returns NULL where the table has no such row.
const sideray_option* find(const Table& table, const std::string& name);

// Refuses unknown options, empty values and unknown choices. Throws UsageError.
void check_given(const Table& table, const Given& given);

// Returns the given text, or else the default.
std::string text_of(const Table& table, const Given& given, const std::string& name);

// Throw UsageError that names the option and the accepted range.
double number(const std::string& name, const std::string& text, double low, double high);
uint32_t whole_number(const std::string& name, const std::string& text, uint32_t low, uint32_t high);
// Do the same with the row's range, for the given text or the default.
double number_of(const Table& table, const Given& given, const std::string& name);
uint32_t whole_number_of(const Table& table, const Given& given, const std::string& name);

std::vector<std::string> split(const std::string& text, char separator);

}  // namespace sideray::cli
