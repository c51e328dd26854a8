#include "bridge/renderer/answer_outputs.h"

#include "rt/cache/older_layers.h"
#include "rt/masks/older_masks.h"
#include "rt/reflections/older_reflections.h"
#include "rt/reflections/reflection_tracing.h"

namespace sideray::bridge {
namespace {

// Values of the channels. Reused answers add Backend::answers() to `traced`.
enum : uint32_t { asks_for_none = 0, has_none = 1, traced = 2 };

constexpr uint8_t no_answer = rt::OlderMasks::no_answer;
static_assert(rt::OlderReflections::no_answer == no_answer && rt::OlderLayers::no_answer == no_answer);

// `asks(i)`: whether a pixel needs an answer; `has_own(i)`: whether it has one in frames without history.
template <typename Asks, typename HasOwn>
void add_channel(const PictureJob& job, Picture& picture, const char* name, AnswerOf of, const Asks& asks, const HasOwn& has_own) {
  const std::vector<uint8_t> answers = job.backend.answers(of);
  add_plane(picture, name, [&](size_t i) -> uint32_t {
    if (!asks(i)) return asks_for_none;
    if (answers.empty()) return has_own(i) ? traced : has_none;
    return answers[i] == no_answer ? has_none : traced + answers[i];
  });
}

void add_masks(const PictureJob& job, Picture& picture) {
  const std::vector<float> depth = job.backend.read_depth();
  const float background = job.view_of(0).reversed_depth ? 0.0f : 1.0f;
  const auto is_surface = [&](size_t i) { return depth[i] != background; };
  const auto always = [](size_t) { return true; };
  if (job.plan.masks_shadows()) add_channel(job, picture, "answer.lights", AnswerOf::lights, is_surface, always);
  if (job.plan.masks.ao_rays > 0) add_channel(job, picture, "answer.sky", AnswerOf::sky, is_surface, always);
}

void add_reflections(const PictureJob& job, Picture& picture) {
  const std::vector<float> depth = job.backend.read_depth();
  const std::vector<glm::vec4> normals = job.backend.read_gbuffer().normal_roughness;
  const float background = job.view_of(0).reversed_depth ? 0.0f : 1.0f;
  const auto mirrors = [&](size_t i) {
    return depth[i] != background && rt::reflection_share(normals[i].w, job.plan.reflections.max_roughness) > 0.0f;
  };
  add_channel(job, picture, "answer.reflections", AnswerOf::reflections, mirrors, [](size_t) { return true; });
}

// Adds nothing for a composite under a bound, which does not tell where it is incomplete.
void add_layers(const PictureJob& job, Picture& picture) {
  const bool may_lack = job.options.is_bounded() && !job.plan.draws_by_rays();
  if (job.plan.composites() && may_lack) return;
  const std::vector<uint8_t> counts = job.backend.count_translucent(job);
  const auto is_glass = [&](size_t i) { return (counts[i] & gl::mask_stencil_bits) != 0; };
  const rt::LayerCache* cache = job.plan.fills_cache() ? &job.backend.read_layers(job) : nullptr;
  add_channel(job, picture, "answer.layers", AnswerOf::layers, is_glass,
              [&](size_t i) { return !cache || cache->distance[i] != 0.0f; });
}

}  // namespace

void add_answers(const PictureJob& job, Picture& picture) {
  if (!job.options.shows(SIDERAY_AOV_ANSWERS)) return;
  if (job.plan.masks_occlusion()) add_masks(job, picture);
  if (job.plan.reflects) add_reflections(job, picture);
  if (job.plan.traces) add_layers(job, picture);
}

}  // namespace sideray::bridge
