#include "cli/render/render_run.h"

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/record/task_note.h"

namespace sideray::cli {

void prepare_run(std::vector<RenderOptions>& renders) {
  for (RenderOptions& render : renders) {
    if (render.bounds.any())
      wrong_usage("--{}: every task would choose for itself; give the options that sideray plan chooses instead",
                  render.bounds.most_ms ? "max-ms" : "max-error");
    render.resume = true;
  }
  make_folder(run_folder(renders));
}

int render_run(const std::vector<RenderOptions>& renders, const TaskShard& shard,
               const std::function<int(size_t index, const RunJob& job)>& draw) {
  RunRecord run{run_folder(renders), "render", shard.scheduler, shard.count, {}};
  for (const RenderOptions& render : renders) run.work["jobs"].push_back(job_of(render, run.folder));
  join_run(run);
  return run_task(run, shard, [&] {
    for (size_t i = 0; i < renders.size(); ++i) {
      if (!renders[i].frames && !is_of_shard(i, shard)) continue;
      if (const int code = draw(i, {run.work["jobs"][i], shard}); code != exit_ok) return code;
    }
    return exit_ok;
  });
}

}  // namespace sideray::cli
