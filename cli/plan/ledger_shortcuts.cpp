#include "cli/plan/ledger_shortcuts.h"

#include <algorithm>

#include <fmt/format.h>

namespace sideray::cli {
namespace {

using scenes::Content;

bool is_translucent(const sideray_material_desc& m) {
  return m.alpha_mode == SIDERAY_BLEND || m.transmission > 0.0f;
}

bool has_translucency(const Content& content) {
  return std::any_of(content.objects.begin(), content.objects.end(), [&](const scenes::Object& object) {
    return is_translucent(content.materials[object.material].desc);
  });
}

// Whether any surface takes the inexact shadow test, as the renderer decides it.
bool takes_inexact(const Content& content, sideray_inexact_target target) {
  return std::any_of(content.objects.begin(), content.objects.end(), [&](const scenes::Object& object) {
    const scenes::Material& m = content.materials[object.material];
    if (is_translucent(m.desc)) return false;
    if (target == SIDERAY_TARGET_MODEL)
      return m.desc.double_sided != 0 && (m.desc.alpha_mode == SIDERAY_MASK || m.desc.diffuse_transmission > 0.0f);
    return object.wind != 0 || m.inexact_shadow;
  });
}

// Goes through the configuration from the layers to the picture as a whole.
class Finder {
 public:
  Finder(const RenderOptions& base, const LedgerScene& scene)
      : o_(base.options), content_(*scene.content), layered_(scene.layered), all_layered_(scene.all_layered) {
    is_hybrid_ = o_.translucency == SIDERAY_TRANSLUCENCY_HYBRID && o_.layers > 0 && layered_ > 0;
    is_raytraced_ = o_.translucency == SIDERAY_TRANSLUCENCY_RAYTRACED;
    is_exact_ = o_.translucency == SIDERAY_TRANSLUCENCY_REFERENCE;
    has_particles_ = !content_.emitters.empty();
    has_translucency_ = has_translucency(content_) || has_particles_;
  }

  Shortcuts find() {
    if (!has_translucency_)
      absent("translucency", "the scene has no translucent surface: no layers, order, match or rate to lose by");
    else
      find_translucency();
    find_depth();
    find_shadows();
    find_poses();
    find_randomness();
    find_unsplit();
    make_chain();
    return std::move(result_);
  }

 private:
  void taken(const char* name, std::string what, lab::Configuration off, bool is_random = false) {
    result_.taken.push_back({name, std::move(what), std::move(off), is_random, false});
  }
  void absent(const char* name, std::string reason) { result_.absent.push_back({name, std::move(reason)}); }
  void inseparable(const char* name, std::string reason) { result_.inseparable.push_back({name, std::move(reason)}); }

  void find_translucency() {
    if (is_exact_) return absent("translucency", "translucent surfaces are shaded as in the reference");
    if (is_raytraced_) return find_raytraced();
    if (is_hybrid_)
      find_hybrid();
    else
      find_without_layers();
    if (o_.translucency == SIDERAY_TRANSLUCENCY_OFF) return;
    if (o_.oit == SIDERAY_OIT_ABUFFER || o_.oit == SIDERAY_OIT_PEEL)
      absent("order", "every fragment is in its place already");
    else
      taken("order", "fragments blended in an order that is not that of each pixel; instead peeled, to the last one",
            {{"oit", "peel"}});
  }

  void find_without_layers() {
    const lab::Configuration layers{{"translucency", "hybrid"}, {"layers", "8"}, {"ray-traced", "all"}};
    if (o_.translucency == SIDERAY_TRANSLUCENCY_OFF) {
      lab::Configuration ordered = layers;
      ordered["oit"] = "peel";
      taken("off", "translucent surfaces are not drawn; instead from 8 ray-traced layers in exact order", ordered);
    } else if (all_layered_ == 0) {
      absent("raster", "no translucent object can have layers");
    } else {
      taken("raster", "translucent surfaces shaded by the rasterizer; instead from 8 ray-traced layers", layers);
    }
  }

  void find_hybrid() {
    if (layered_ < all_layered_)
      taken("objects",
            fmt::format("{} of {} translucent objects that could have layers have none; instead all have",  //
                        all_layered_ - layered_, all_layered_),
            {{"ray-traced", "all"}});
    else
      absent("objects", "every translucent object that can have layers has them");
    if (o_.layers < 8)
      taken("layers",
            fmt::format("surfaces behind the first {} of a pixel keep raster shading; instead behind 8", o_.layers),
            {{"layers", "8"}});
    else
      absent("layers", "8 is as many as a cache holds; what lies deeper is in residual.cache");
    if (o_.match != SIDERAY_MATCH_ID)
      taken("match", "fragments find their layers by distance; instead by surface id", {{"match", "id"}});
    find_steps();
    find_rate();
    if (o_.radiance_format != SIDERAY_RADIANCE_RGBA16F)
      taken("format", "layers are kept in rgb9e5; instead in rgba16f", {{"radiance-format", "rgba16f"}});
    else
      absent("format", "layers are kept in half floats, as the picture is");
  }

  void find_rate() {
    const bool is_temporal = o_.cache_rate == SIDERAY_RATE_TEMPORAL4 || o_.cache_rate == SIDERAY_RATE_TEMPORAL8;
    if (o_.cache_rate == SIDERAY_RATE_FULL) return absent("rate", "every masked pixel is traced");
    if (is_temporal) return absent("rate", "temporal rates trace every masked pixel of a single picture");
    taken("rate", "some pixels take their neighbours' layers; instead every masked pixel is traced",
          {{"cache-rate", "full"}});
    if (o_.second_wave == 0)
      taken("second-wave", "pixels without such a neighbour keep raster shading; instead they are traced",
            {{"second-wave", "on"}});
  }

  void find_steps() {
    if (o_.step == SIDERAY_STEP_LISTING)
      taken("step", "rays step as listing 50-1; instead they meet every surface", {{"step", "multihit"}});
    else
      absent("step", "rays meet every surface once");
    if (o_.mask != SIDERAY_NO_MASK)
      taken("mask", "rays start where the rasterizer marked pixels; instead in every pixel", {{"mask", "none"}});
    else
      absent("mask", "rays start in every pixel");
  }

  void find_raytraced() {
    if (o_.layers != 0)
      taken("layers", fmt::format("rays end behind {} surfaces; instead behind the last one", o_.layers),
            {{"layers", "unlimited"}});
    else
      absent("layers", "rays go to the last surface");
    find_steps();
    if (has_particles_ && o_.rt_particles == 0)
      taken("particles", "particles are left out; instead rays meet them as quads", {{"rt-particles", "on"}});
    absent("order", "rays meet surfaces in their order");
  }

  void find_shadows() {
    if (o_.shadows == SIDERAY_SHADOWS_OFF) {
      absent("bias", "no shadows, in the reference neither");
    } else if (o_.shadows == SIDERAY_SHADOWS_MAP) {
      taken("shadow-maps", "shadows of opaque surfaces from maps; instead by rays", {{"shadows", "exact"}});
    } else if (o_.shadows == SIDERAY_SHADOWS_EXACT || !takes_inexact(content_, o_.inexact_target)) {
      absent("bias", o_.shadows == SIDERAY_SHADOWS_EXACT ? "shadow rays are exact"
                                                         : "nothing in the scene takes the inexact shadow test");
    } else {
      taken("bias", "shadow rays of marked surfaces take the inexact test; instead all are exact",
            {{"shadows", "exact"}});
    }
    if (o_.ao != 0)
      taken("ambient", "ambient occlusion, which the reference's equations have not; instead none", {{"ao", "off"}});
  }

  void find_depth() {
    const bool by_rays = o_.shadows == SIDERAY_SHADOWS_EXACT || o_.shadows == SIDERAY_SHADOWS_INEXACT ||  //
                         o_.ao != 0 || o_.reflections != 0;
    if (!by_rays) return absent("depth", "no rays start at opaque pixels");
    taken("depth", "rays of opaque pixels start where the depth buffer has them; instead where a ray meets them", {});
    result_.taken.back().is_exact = true;
  }

  void find_poses() {
    if (o_.cull_angle_deg > 0 && !is_exact_)
      taken("culling",
            fmt::format("rays do not meet what appears under {} degrees; instead they meet everything",
                        o_.cull_angle_deg),
            {{"cull-angle", "0"}});
    else
      absent("culling", "rays meet everything, however small it looks");
    const bool is_moved = std::any_of(content_.objects.begin(), content_.objects.end(),
                                      [](const scenes::Object& object) { return object.wind != 0; });
    if (!is_moved)
      absent("pose", "nothing is moved by wind");
    else if (is_exact_ || (o_.foliage == SIDERAY_FOLIAGE_UNIQUE && o_.unique_cap == 0))
      absent("pose", "rays meet every instance in its own pose");
    else
      taken("pose", "rays meet plants in a pose that is not that of each instance; instead in its own",
            {{"foliage", "unique"}, {"unique-cap", "none"}});
  }

  bool traces_light() const {
    const bool masks = o_.shadows == SIDERAY_SHADOWS_EXACT || o_.shadows == SIDERAY_SHADOWS_INEXACT || o_.ao != 0;
    return masks || o_.reflections != 0 || is_hybrid_ || is_raytraced_;
  }

  void find_randomness() {
    if (!traces_light()) return absent("denoise", "nothing is random: no rays");
    if (o_.denoise != 0)
      taken("denoise", "one random direction a ray, filtered; instead not filtered, the mean of many pictures",
            {{"denoise", "off"}}, true);
    else
      taken("noise", "one random direction a ray; instead the mean of many pictures", {}, true);
  }

  void find_unsplit() {
    absent("stale", "a single picture: temporal rates, anti-aliasing and filters have no frame before it");
    absent("positions", "the reference sees through the same positions of each pixel");
    inseparable("environment",
                "prefiltered on opaque surfaces: only the reference samples it; part of residual.opaque");
  }

  void make_chain() {
    lab::Configuration off;
    for (const Shortcut& shortcut : result_.taken) off.insert(shortcut.off.begin(), shortcut.off.end());
    const auto add = [&](const char* name, const char* what, const lab::Configuration& more) {
      lab::Configuration configuration = more;
      configuration.insert(off.begin(), off.end());
      result_.chain.push_back({name, what, configuration, true, true});
    };
    if (has_translucency_ && !is_exact_) {
      if (!is_raytraced_)
        add("cache",
            "fragments and 8 layers at most against rays to the last surface: deeper layers, what no option makes "
            "exact",
            {});
      add("samples",
          "translucent surfaces shaded with one reflection ray and lights without size, against the reference's "
          "samples",
          {{"translucency", "raytraced"}, {"layers", "unlimited"}, {"rt-particles", "on"}});
    }
    add("opaque", "rasterized opaque surfaces and their prefiltered environment, against the reference's",
        {{"translucency", has_translucency_ ? "reference" : "off"}});
  }

  const sideray_render_options& o_;
  const Content& content_;
  size_t layered_, all_layered_;
  bool is_hybrid_, is_raytraced_, is_exact_, has_translucency_, has_particles_;
  Shortcuts result_;
};

}  // namespace

Shortcuts shortcuts_of(const RenderOptions& base, const LedgerScene& scene) {
  return Finder(base, scene).find();
}

}  // namespace sideray::cli
