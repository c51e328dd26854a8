#include "cli/render/run_pictures.h"

#include <algorithm>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "cli/record/sidecar.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const RenderOptions& options) {
  const std::string& output = options.output;
  const std::string fixed = options.frames ? output.substr(0, output.find('#')) : output;
  return fs::absolute(fixed).lexically_normal().parent_path();
}

fs::path common(const fs::path& a, const fs::path& b) {
  fs::path result;
  for (auto [x, y] = std::pair(a.begin(), b.begin()); x != a.end() && y != b.end() && *x == *y; ++x, ++y) result /= *x;
  return result;
}

// Returns a path relative to the folder, if inside: others may see the folder at another place.
std::string from_folder(const std::string& file, const std::string& folder) {
  std::error_code error;
  const fs::path full = fs::weakly_canonical(fs::absolute(file, error), error),
                 near = full.lexically_relative(fs::weakly_canonical(fs::absolute(folder, error), error));
  return near.empty() || *near.begin() == ".." ? full.string() : near.string();
}

std::string in_folder(const std::string& file, const std::string& folder) {
  return (fs::path(folder) / file).string();
}

// Hashes a file's content, since it may change while tasks run.
std::string hash_of_file(const std::string& file) {
  constexpr uint64_t most_bytes = uint64_t{16} << 30;
  return fmt::format("{:016x}", scenes::hash_of(scenes::read_file(file, most_bytes)));
}

struct RecordedPicture {
  const Json& job;
  std::optional<uint32_t> frame;
  std::string path;
  uint32_t shard;
};

std::optional<FrameRange> range_of(const Json& job) {
  if (!job.contains("frames")) return {};
  return frame_range({{"frames", job["frames"].get<std::string>()}});
}

std::vector<RecordedPicture> pictures_of(const RunRecord& run) {
  std::vector<RecordedPicture> pictures;
  const Json& jobs = run.work.at("jobs");
  for (size_t i = 0; i < jobs.size(); ++i) {
    const std::string output = in_folder(jobs[i].at("o").get<std::string>(), run.folder);
    const std::optional<FrameRange> range = range_of(jobs[i]);
    if (!range) {
      pictures.push_back({jobs[i], {}, output, static_cast<uint32_t>(i % run.shards)});
      continue;
    }
    for (uint32_t shard = 0; shard < run.shards; ++shard) {
      const Block block = block_of(range->first, range->count(), {shard, run.shards});
      for (uint32_t frame = block.begin; frame < block.end; ++frame)
        pictures.push_back({jobs[i], frame, frame_path(output, frame), shard});
    }
  }
  return pictures;
}

}  // namespace

std::string run_folder(std::span<const RenderOptions> renders) {
  fs::path folder = folder_of(renders.front());
  for (const RenderOptions& render : renders) folder = common(folder, folder_of(render));
  if (folder == folder.root_path())
    wrong_usage(
        "--shard auto: the pictures have no folder in common, to record the run in; write all of them below one");
  const bool is_relative = fs::path(renders.front().output).is_relative();
  return is_relative ? folder.lexically_proximate(fs::current_path()).string() : folder.string();
}

Json job_of(const RenderOptions& options, const std::string& folder) {
  Json job = {{"scene", options.scene}};
  for (const auto& [name, text] : options.given)
    if (name != "shard" && name != "resume" && name != "threads")
      job[name] = name == "o" || name == "stats" || name == "truth" ? from_folder(text, folder) : text;
  for (const auto& [name, file] : {std::pair{"scene-hash", options.scene}, std::pair{"env-hash", options.environment}})
    if (fs::is_regular_file(file)) job[name] = hash_of_file(file);
  return job;
}

bool is_of_shard(size_t job, Shard shard) {
  return job % shard.count == shard.index;
}

Json picture_options(const Json& job, std::optional<uint32_t> frame) {
  Json options = job;
  if (frame) options["frame"] = *frame;
  return options;
}

std::optional<Json> made_picture(const std::string& picture, const Json& options) {
  std::optional<Json> sidecar = read_sidecar(picture, options);
  if (sidecar && (sidecar->value("program", "") != program_build() || !has_written_bytes(picture, *sidecar))) return {};
  return sidecar;
}

std::vector<RunPart> picture_parts(const RunRecord& run, bool reads_all) {
  const bool is_one_sequence = run.work.at("jobs").size() == 1;
  std::vector<RunPart> parts;
  for (const RecordedPicture& picture : pictures_of(run)) {
    RunPart part{picture.path, picture.shard, picture.path, "", ""};
    if (is_one_sequence && picture.frame) part.name = *picture.frame;
    const std::optional<Json> sidecar = read_sidecar(picture.path, picture_options(picture.job, picture.frame));
    if (sidecar && (!reads_all || has_written_bytes(picture.path, *sidecar))) {
      part.program = sidecar->value("program", "");
      part.device = sidecar->value(Json::json_pointer("/device/renderer"), "");
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

void gather_stats(const RunRecord& run) {
  std::map<std::string, std::string> texts;
  for (const RecordedPicture& picture : pictures_of(run)) {
    if (!picture.frame || !picture.job.contains("stats")) continue;
    Json line = {{"frame", *picture.frame}};
    line.update(read_sidecar(picture.path, picture_options(picture.job, picture.frame)).value().at("stats"));
    texts[in_folder(picture.job["stats"].get<std::string>(), run.folder)] += scenes::json_text(line) + "\n";
  }
  for (const auto& [path, text] : texts) {
    write_text(path, text);
    fmt::print("statistics: {}\n", path);
  }
}

}  // namespace sideray::cli
