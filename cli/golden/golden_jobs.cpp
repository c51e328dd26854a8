#include "cli/golden/golden_jobs.h"

#include <filesystem>
#include <map>

#include "cli/base/failure.h"
#include "cli/render/render_jobs.h"
#include "cli/session/session.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

lab::Configuration held_still(lab::Configuration job, const std::string& name) {
  for (const auto& [option, value] : job)
    if (depends_on_time(option))
      wrong_usage("{}: {}: the picture depends on how fast the machine is and cannot be held still; remove it", name,
                  dashed(option));
  for (const char* of_run : {"stats", "truth", "resume", "shard", "warm-up"}) job.erase(of_run);
  return job;
}

std::string inside(const std::string& output, const std::string& name) {
  const fs::path path = fs::path(output).lexically_normal();
  if (path.is_absolute() || *path.begin() == "..")
    wrong_usage("{}: o {}: is no name inside of the folder of references; give a relative one", name, output);
  return path.string();
}

std::string without_extension(const std::string& file) {
  return fs::path(file).replace_extension().string();
}

GoldenPicture picture_named(const std::string& file, const RenderOptions& options) {
  GoldenPicture picture;
  picture.name = without_extension(file);
  picture.file = file;
  picture.ids = picture.name + ".ids.exr";
  picture.width = options.width(), picture.height = options.height();
  return picture;
}

// "a.png" and "a.exr" would both be "a"; "a.ids.exr" belongs to "a".
void require_files_apart(const std::vector<GoldenJob>& jobs) {
  std::map<std::string, const GoldenJob*> writers;
  for (const GoldenJob& job : jobs)
    for (const GoldenPicture& picture : pictures_of(job))
      for (const std::string& file : {picture.file, picture.ids}) {
        const auto [other, first] = writers.emplace(file, &job);
        if (!first)
          wrong_usage("{}: writes {} as {} does; choose another name", job.name, file, other->second->name);
      }
}

}  // namespace

bool depends_on_time(const std::string& option) {
  for (const char* name : {"max-ms", "max-error", "budget", "deadline"})
    if (option == name) return true;
  return false;
}

std::vector<GoldenJob> golden_jobs(const std::vector<lab::Configuration>& jobs, const std::string& path,
                                   const Given& options) {
  std::vector<lab::Configuration> kept;
  for (size_t i = 0; i < jobs.size(); ++i) kept.push_back(held_still(jobs[i], job_name(path, i)));
  std::vector<GoldenJob> golden;
  for (RenderOptions& render : resolve_jobs(kept, path, options)) {
    const std::string name = job_name(path, golden.size());
    render.output = inside(render.output, name);
    render.aovs.bits |= SIDERAY_AOV_FIRST;
    golden.push_back({name, render.output, std::move(render)});
  }
  require_files_apart(golden);
  SceneChecks scenes;
  for (const GoldenJob& job : golden) of_job(job.name, [&] { scenes.check(job.options); });
  return golden;
}

std::vector<GoldenPicture> pictures_of(const GoldenJob& job) {
  std::vector<GoldenPicture> pictures;
  if (!job.options.frames) return {picture_named(job.output, job.options)};
  const FrameRange& frames = *job.options.frames;
  for (uint32_t k = 0; k < frames.count(); ++k)
    pictures.push_back(picture_named(frame_path(job.output, frames.first + k), job.options));
  return pictures;
}

}  // namespace sideray::cli
