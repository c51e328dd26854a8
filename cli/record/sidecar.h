// Records how a picture of a run was made, in PICTURE.json beside it. The picture itself has no trace of host, shard or
// time. Any thread.
#pragma once

#include <optional>

#include "cli/record/run_record.h"

namespace sideray::cli {

// Writes the sidecar, after the picture: one without the other counts as missing. `options`: of the record, with the
// frame if there is one; `stats`: of the picture, all of which are kept with `keeps_stats`.
void write_sidecar(const std::string& picture, const Json& options, Shard shard, const Json& stats, bool keeps_stats);

// Returns nothing where the picture is missing, has another size than was written, or was made with other options.
std::optional<Json> read_sidecar(const std::string& picture, const Json& options);

// Returns whether the picture still has the bytes that were written; reads all of it.
bool has_written_bytes(const std::string& picture, const Json& sidecar);

std::string sidecar_path(const std::string& picture);

}  // namespace sideray::cli
