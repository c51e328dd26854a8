// Reads the jobs of golden pictures, and draws them. Main thread.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cli/golden/manifest.h"
#include "cli/options/render_options.h"

namespace sideray::cli {

// Returns whether results of an option depend on time, so that they are not reproducible.
bool depends_on_time(const std::string& option);

// Holds one job, with its output as a path inside a folder.
struct GoldenJob {
  std::string name;  // for errors
  std::string output;
  RenderOptions options;
};

// `path`: names the file in errors. Ignores options that only say how a run proceeds (stats, truth, resume, shard).
// Throws UsageError for jobs that are not reproducible, for outputs that are no names inside a folder, and for two
// pictures of one name; Error or UsageError for jobs that cannot be drawn.
std::vector<GoldenJob> golden_jobs(const std::vector<lab::Configuration>& jobs, const std::string& path,
                                   const Given& options);

// Returns the pictures of a job, with only their names and files.
std::vector<GoldenPicture> pictures_of(const GoldenJob& job);

// Holds a picture as it was drawn and written.
struct DrawnPicture {
  GoldenPicture golden;
  scenes::Image picture, ids;                 // as read from the files
  scenes::Image radiance;                     // before exposure and tone mapping
  std::map<std::string, uint32_t> objects;    // of the whole scene: number of objects by name
  lab::Display display;
  double seconds = 0;
};

// Draws the pictures of all jobs with `threads` (0: as the jobs say) and writes each to `file_of` of its name.
void draw_golden(const std::vector<GoldenJob>& jobs, uint32_t threads,
                 const std::function<std::string(const std::string& name)>& file_of,
                 const std::function<void(DrawnPicture&& drawn)>& take);

}  // namespace sideray::cli
