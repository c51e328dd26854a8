#include "cli/plan/ledger_shortcuts.h"

#include <memory>

namespace sideray::cli {
namespace {

struct ReleaseShortcuts {
  void operator()(sideray_shortcuts* list) const { sideray_shortcuts_release(list); }
};

// Adds the shortcuts that the library reports for the scene.
void add_of_options(const RenderOptions& base, const sideray_scene_facts& facts, Shortcuts& result) {
  sideray_shortcuts* list = nullptr;
  check([&](sideray_error* error) { return sideray_shortcuts_create(base.named.get(), &facts, &list, error); });
  const std::unique_ptr<sideray_shortcuts, ReleaseShortcuts> owner(list);
  for (size_t i = 0; i < sideray_shortcuts_count(list); ++i) {
    const sideray_shortcut& s = *sideray_shortcuts_at(list, i);
    if (!s.taken) {
      result.absent.push_back({s.name, s.text});
      continue;
    }
    Shortcut shortcut{s.name, s.text, {}, s.is_random != 0, false};
    for (size_t k = 0; k < s.exactly_count; ++k) shortcut.off[s.exactly[k].name] = s.exactly[k].value;
    result.taken.push_back(std::move(shortcut));
  }
}

void add_depth(const RenderOptions& base, const sideray_scene_facts& facts, Shortcuts& result) {
  const sideray_render_options& o = base.named.render();
  const std::string shadows = sideray_options_get(base.named.get(), "shadows");
  const bool ambient = o.ambient == SIDERAY_AMBIENT_AUTO ? facts.auto_ao + facts.auto_bounce != 0 : o.ambient != SIDERAY_AMBIENT_OFF;
  const bool reflections = o.reflections == SIDERAY_REFLECTIONS_AUTO ? facts.auto_reflections != 0 : o.reflections != 0;
  const bool by_rays =
      shadows == "exact" || shadows == "inexact" || ambient || reflections;
  if (by_rays)
    result.taken.push_back(
        {"depth", "rays of opaque pixels start where the depth buffer has them; instead where a ray hits them",
         {}, false, true});
  else
    result.absent.push_back({"depth", "no rays start at opaque pixels"});
}

void add_unsplit(Shortcuts& result) {
  result.absent.push_back(
      {"stale", "a single picture: anti-aliasing and filters have no frame before it"});
  result.absent.push_back({"positions", "the reference sees through the same positions of each pixel"});
  result.inseparable.push_back(
      {"environment", "prefiltered on opaque surfaces: only the reference samples it; part of residual.opaque"});
}

// Makes the chain of steps from the picture without shortcuts to the reference.
void make_chain(const RenderOptions& base, const sideray_scene_facts& facts, Shortcuts& result) {
  lab::Configuration off;
  for (const Shortcut& shortcut : result.taken) off.insert(shortcut.off.begin(), shortcut.off.end());
  const auto add = [&](const char* name, const char* what, lab::Configuration configuration) {
    configuration.insert(off.begin(), off.end());
    result.chain.push_back({name, what, std::move(configuration), true, true});
  };
  const bool has_translucency = facts.translucent_objects > 0 || facts.sprites > 0;
  if (has_translucency && !base.is_exact()) {
    if (base.translucency() != SIDERAY_TRANSLUCENCY_RAYTRACED)
      add("cache",
          "fragments and 8 layers at most against rays to the last surface: deeper layers, what no option makes exact",
          {});
    add("samples",
        "translucent surfaces shaded with one reflection ray and lights without size, against the reference's samples",
        {{"translucency", "raytraced"}, {"layers", "unlimited"}, {"rt-particles", "on"}});
  }
  add("opaque", "rasterized opaque surfaces and their prefiltered environment, against the reference's",
      {{"translucency", has_translucency ? "reference" : "off"}});
}

}  // namespace

Shortcuts shortcuts_of(const RenderOptions& base, const sideray_scene_facts& facts) {
  Shortcuts result;
  add_of_options(base, facts, result);
  add_depth(base, facts, result);
  add_unsplit(result);
  make_chain(base, facts, result);
  return result;
}

}  // namespace sideray::cli
