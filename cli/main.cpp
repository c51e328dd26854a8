// The program: reads options, runs the command, returns the exit code.
#include <sideray/sideray.h>
#include <CLI/CLI.hpp>

#include <cxxabi.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <system_error>
#include <typeinfo>
#include <utility>
#include <vector>

#include "cli/base/failure.h"
#include "cli/base/near_name.h"
#include "cli/commands.h"
#include "cli/options/options.h"

namespace sideray::cli {
namespace {

std::string version_line() {
  int major = 0, minor = 0, patch = 0;
  sideray_version(&major, &minor, &patch);
  return fmt::format("sideray {}.{}.{}", major, minor, patch);
}

std::vector<Command> add_commands(CLI::App& program) {
  return {add_render(program), add_view(program),   add_run(program),   add_bench(program), add_chart(program),  add_stress(program),
          add_plan(program),   add_compare(program), add_info(program),   add_make(program),
          add_status(program), add_gather(program), add_golden(program),  add_devices(program),
          add_option_list(program)};
}

// Names the replacement of the first option that only version 0.2 had. Throws UsageError.
void refuse_removed(const CLI::App& program, int argc, char** argv) {
  const std::vector<CLI::App*> commands = program.get_subcommands();
  // Only commands that draw had such options.
  if (commands.empty() || !commands.front()->get_option_no_throw("--diagnose")) return;
  for (const std::string argument : std::span(argv, static_cast<size_t>(argc)).subspan(1)) {
    if (!argument.starts_with("--")) continue;
    const std::string name = argument.substr(2, argument.find('=') - 2);
    if (commands.front()->get_option_no_throw("--" + name)) continue;
    if (const std::string instead = instead_of(name); !instead.empty())
      wrong_usage("--{}: is gone since 0.3; {}", name, instead);
  }
}

// Returns the last command on the command line, such as `record` in `sideray golden record`, and its whole name.
std::pair<const CLI::App*, std::string> chosen_command(const CLI::App& program) {
  const CLI::App* command = &program;
  std::string name = program.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  return {command, name};
}

// Includes rare options, but not those without effect, which have no description.
std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_description().empty())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> commands_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* each : command.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(each->get_name());
  return names;
}

[[noreturn]] void refuse_as(const char* what, const std::string& word, const std::vector<std::string>& known,
                            const std::string& command) {
  wrong_usage("{}: {}; {}see {} --help", word, what, did_you_mean(near_name(word, known)), command);
}

// Names an argument that the command does not know, and what it probably means. Throws UsageError.
void refuse_unknown(const CLI::App& program) {
  const auto [command, name] = chosen_command(program);
  std::vector<std::string> unknown = command->remaining();
  std::erase(unknown, "--");
  if (unknown.empty()) return;
  const std::vector<std::string> commands = commands_of(*command);
  const auto is_option = [](const std::string& word) { return word.starts_with("-"); };
  if (!commands.empty() && !is_option(unknown.front()))
    refuse_as("no such command", unknown.front(), commands, name);
  // The value of an unknown option is unknown too, and may stand before the option.
  const auto option = std::find_if(unknown.begin(), unknown.end(), is_option);
  if (option == unknown.end()) refuse_as("one argument too many", unknown.front(), {}, name);
  refuse_as("no such option", option->substr(0, option->find('=')), options_of(*command), name);
}

int run(int argc, char** argv) {
  CLI::App program("Sideray: ray-traced translucency beside an OpenGL rasterizer", "sideray");
  program.set_version_flag("--version", version_line());
  program.require_subcommand(0, 1);
  const std::vector<Command> commands = add_commands(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    refuse_removed(program, argc, argv);
    refuse_unknown(program);
    wrong_usage("command line: {}; see sideray --help or sideray COMMAND --help", error.what());
  }
  for (const Command& command : commands)
    if (command.app->parsed()) return command.run();
  wrong_usage("command line: no command; see sideray --help");
}

void print_output_error(int reason) {
  print_error(
      fmt::format("standard output: {}; free space or redirect elsewhere", std::strerror(reason != 0 ? reason : EIO)));
}

// Flushes output, where a full disk may show only now, and returns the exit code.
int checked_output(int exit_code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  print_output_error(errno);
  return exit_failed;
}

// Prints a line without allocating, for when there is no memory.
void print_fixed(const char* line) {
  (void)!::write(STDERR_FILENO, line, std::strlen(line));
}

constexpr const char* no_memory =
    "sideray: memory: this machine has not enough for the picture or scene; make it smaller\n";

// Ends the program where no handler catches an exception: code that must not throw, such as a destructor, ran out of
// memory, or the exception itself did. Output files are renamed last, so that the old ones are still there.
[[noreturn]] void end_by_exit_code() {
  const std::type_info* const type = abi::__cxa_current_exception_type();
  if (!type || *type == typeid(std::bad_alloc)) {
    print_fixed(no_memory);
  } else {
    print_fixed("sideray: stopped: an error came where none can be reported (");
    print_fixed(type->name());
    print_fixed("); try again with more memory, and report this if it comes back\n");
  }
  ::_exit(exit_failed);
}

// Runs before the constructors of all libraries, which may also need memory.
void prepare() {
  std::set_terminate(end_by_exit_code);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const prepare_first)() = prepare;

}  // namespace
}  // namespace sideray::cli

int main(int argc, char** argv) {
  using namespace sideray::cli;
  // Lets write() fail where a file outgrows `ulimit -f`, instead of ending the program. Unlike SIG_IGN, a handler is not
  // inherited by what `sideray run` starts.
  std::signal(SIGXFSZ, [](int) {});
  try {
    return checked_output(run(argc, argv));
  } catch (const UsageError& error) {
    print_error(error.what());
    return exit_usage;
  } catch (const std::bad_alloc&) {
    print_fixed(no_memory);
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0)
      print_output_error(error.code().value());
    else
      print_error(error.what());
  } catch (const std::exception& error) {
    print_error(error.what());
  }
  return exit_failed;
}
