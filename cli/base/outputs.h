// Output files: names checked before any work, text written whole or not at all. Any thread.
#pragma once

#include <string>
#include <vector>

namespace sideray::cli {

// Lower-case extension with its dot. Throws UsageError where it is not one of `accepted`; `what` names the option.
std::string require_extension(const std::string& what, const std::string& path,
                              const std::vector<std::string>& accepted);

// Throws Error where no file of this name can be written.
void require_writable(const std::string& path);

// With all folders above it. Throws Error where that cannot be.
void make_folder(const std::string& path);

void write_text(const std::string& path, const std::string& text);

// The same where no such file exists; of many processes that try at once one succeeds, and the others get false. The folder
// has to know hard links, as those of clusters do (NFS, Lustre). Throws Error.
bool write_text_once(const std::string& path, const std::string& text);

// Whether a file's name is that of one that a killed process left half-written.
bool is_unfinished(const std::string& name);

struct NamedFile {
  std::string what, path;  // what: the option; path "" = none
};

// Throws UsageError where a file to write is another file to write or to read.
void require_distinct(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read);

}  // namespace sideray::cli
