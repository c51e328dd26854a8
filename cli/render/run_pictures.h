// Lists the pictures of a render that many tasks share, and finds which exist. Main thread.
#pragma once

#include <optional>
#include <span>

#include "cli/options/render_options.h"
#include "cli/record/run_part.h"

namespace sideray::cli {

// Holds what sidecars record of a render in a run.
struct RunJob {
  Json options;  // as recorded
  Shard shard;
};

// Returns the folder that all outputs have in common, where the run is recorded. Throws UsageError where there is none.
std::string run_folder(std::span<const RenderOptions> renders);

// Returns the record of a render: all given options that say what is made, and hashes of its input files (of a .gltf
// without its buffers). Files in the folder have relative paths.
Json job_of(const RenderOptions& options, const std::string& folder);

// Returns whether a single picture of a list belongs to a shard: index modulo N is I. Sequences belong to all.
bool is_of_shard(size_t job, Shard shard);

// Returns the options of one frame's picture as its sidecar has them; for a single picture, the job's own.
Json picture_options(const Json& job, std::optional<uint32_t> frame);

// Returns the sidecar if this program made the complete picture with these options.
std::optional<Json> made_picture(const std::string& picture, const Json& options);

// Returns all pictures of the run. `reads_all`: pictures without the bytes that were written also count as missing.
std::vector<RunPart> picture_parts(const RunRecord& run, bool reads_all);

// Writes the requested statistics of sequences from the sidecars of a complete run.
void gather_stats(const RunRecord& run);

}  // namespace sideray::cli
