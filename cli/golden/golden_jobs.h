// The jobs of golden pictures, and drawing them. Main thread.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cli/golden/manifest.h"
#include "cli/options/render_options.h"

namespace sideray::cli {

// Whether what is drawn depends on how long it takes, so that it cannot be held still.
bool depends_on_time(const std::string& option);

// One job, with its output as a path inside of a folder.
struct GoldenJob {
  std::string name;  // what errors call it
  std::string output;
  RenderOptions options;
};

// `path`: what errors call the file. What says how a run goes on (stats, truth, resume, shard) is not regarded. Throws
// UsageError for jobs that cannot be held still, for outputs that are no names inside of a folder, and for two
// pictures of one name; Error or UsageError for what cannot be drawn.
std::vector<GoldenJob> golden_jobs(const std::vector<lab::Configuration>& jobs, const std::string& path,
                                   const Given& options);

// The pictures that a job makes: names and files alone.
std::vector<GoldenPicture> pictures_of(const GoldenJob& job);

// A picture as it was drawn and written.
struct DrawnPicture {
  GoldenPicture golden;
  scenes::Image picture, ids;                 // as the files have them
  scenes::Image radiance;                     // before exposure and tone mapping
  std::map<std::string, uint32_t> objects;    // of the whole scene: how many of each name
  lab::Display display;
  double seconds = 0;
};

// Draws the pictures of all jobs with `threads` (0: as the jobs say) and writes each where `file_of` says.
void draw_golden(const std::vector<GoldenJob>& jobs, uint32_t threads,
                 const std::function<std::string(const std::string& name)>& file_of,
                 const std::function<void(DrawnPicture&& drawn)>& take);

}  // namespace sideray::cli
