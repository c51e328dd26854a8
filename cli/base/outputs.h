// Handles output files: checks names before any work, and writes text completely or not at all. Any thread.
#pragma once

#include <string>
#include <vector>

namespace sideray::cli {

// Returns the lower-case extension with its dot. Throws UsageError if it is not in `accepted`; `what` names the option.
std::string require_extension(const std::string& what, const std::string& path,
                              const std::vector<std::string>& accepted);

// Throws Error where a file of this name cannot be written.
void require_writable(const std::string& path);

// Creates a folder with all its parents. Throws Error where that fails.
void make_folder(const std::string& path);

void write_text(const std::string& path, const std::string& text);

// Does the same if no such file exists, and returns whether it did: of many processes at once, only one does. The file
// system must support hard links, as those of clusters do (NFS, Lustre). Throws Error.
bool write_text_once(const std::string& path, const std::string& text);

// Returns whether a name is that of a file that a killed process left unfinished.
bool is_unfinished(const std::string& name);

struct NamedFile {
  std::string what, path;  // what: the option; path "" = none
};

// Throws UsageError where a file would be written twice, or written and read.
void require_distinct(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read);

}  // namespace sideray::cli
