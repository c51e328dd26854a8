// How a picture of a run was made: PICTURE.json beside it. The picture's own bytes hold nothing of host, shard or time.
// Any thread.
#pragma once

#include <optional>

#include "cli/record/run_record.h"

namespace sideray::cli {

// Written after the picture: one without the other is not there. `options`: of the record, with the frame where there
// is one; `stats`: of the picture; all of them are kept where `keeps_stats`.
void write_sidecar(const std::string& picture, const Json& options, Shard shard, const Json& stats, bool keeps_stats);

// Empty where the picture is not there, has another size than was written or was made with other options.
std::optional<Json> read_sidecar(const std::string& picture, const Json& options);

// Whether the picture still has the bytes that were written: reads all of it.
bool has_written_bytes(const std::string& picture, const Json& sidecar);

std::string sidecar_path(const std::string& picture);

}  // namespace sideray::cli
