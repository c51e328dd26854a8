// The pictures of a render that many tasks share: which there are, which of them are there. Main thread.
#pragma once

#include <optional>
#include <span>

#include "cli/options/render_options.h"
#include "cli/record/run_part.h"

namespace sideray::cli {

// What sidecars say of a render in a run.
struct RunJob {
  Json options;  // as recorded
  Shard shard;
};

// The folder that all outputs have in common: where the run is recorded. Throws UsageError where there is none.
std::string run_folder(std::span<const RenderOptions> renders);

// What is recorded of a render: all that was given and says what is made, and hashes of the files that it is made from
// (of a .gltf without its buffers). Files in the folder are named from there.
Json job_of(const RenderOptions& options, const std::string& folder);

// Where I is the remainder of their place divided by N: single pictures of a list. Every shard has frames of a sequence.
bool is_of_shard(size_t job, Shard shard);

// The options of one frame's picture as its sidecar has them; of a single picture the job's own.
Json picture_options(const Json& job, std::optional<uint32_t> frame);

// Whether a picture is there whole, and drawn by this program with these options; the sidecar, if so.
std::optional<Json> made_picture(const std::string& picture, const Json& options);

// All pictures of the run. `reads_all`: those that have not the bytes that were written are missing, too.
std::vector<RunPart> picture_parts(const RunRecord& run, bool reads_all);

// Writes the statistics of sequences, where they were asked for, from the sidecars of a run that is whole.
void gather_stats(const RunRecord& run);

}  // namespace sideray::cli
