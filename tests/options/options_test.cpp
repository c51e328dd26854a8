// The table of options through the public interface: what each row accepts, refuses, applies to and writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sideray/diagnostics.h>
#include <sideray/plan.h>
#include <sideray/sideray.hpp>
#include <sstream>

namespace sideray {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::vector<const sideray_option*> rows() {
  std::vector<const sideray_option*> list;
  for (size_t i = 0; i < sideray_option_count(); ++i) list.push_back(sideray_option_at(i));
  return list;
}

// What refuses a value: "" where it is taken.
std::string refusal(const Options& options, const std::string& name, const std::string& value) {
  sideray_error error{};
  const sideray_status status = sideray_options_set(options.get(), name.c_str(), value.c_str(), &error);
  EXPECT_EQ(status == SIDERAY_OK, error.message[0] == '\0');
  return error.message;
}

std::string contradiction(const std::vector<std::pair<std::string, std::string>>& values) {
  Options options = Options::create().value();
  for (const auto& [name, value] : values) options.set(name, value);
  sideray_error error{};
  sideray_options_check(options.get(), &error);
  return error.message;
}

// The program has no switch for them, and interfaces of daily use need none.
TEST(OptionTable, ComparatorsAndChecksAreDiagnostics) {
  std::set<std::string> names;
  for (const sideray_option* row : rows())
    if (row->diagnostic) names.insert(row->name);
  EXPECT_EQ(names, (std::set<std::string>{"check", "inexact-bias", "inexact-target", "match", "match-threshold",
                                          "rt-particles", "second-wave", "step", "whole-pixels"}));
}

TEST(OptionTable, RowsSayWhatTheyAre) {
  std::set<std::string> names;
  for (const sideray_option* row : rows()) {
    EXPECT_TRUE(names.insert(row->name).second) << row->name;
    EXPECT_EQ(sideray_option_find(row->name), row);
    for (const char* text :
         {row->placeholder, row->default_value, row->applies, row->exact_value, row->help, row->group})
      ASSERT_NE(text, nullptr) << row->name;
    EXPECT_STRNE(row->help, "") << row->name;
    EXPECT_STRNE(row->group, "") << row->name;
    EXPECT_EQ(row->diagnostic != 0, std::string(row->group) == "Diagnostics") << row->name;
    const bool has_choices = row->type == SIDERAY_OPTION_CHOICE || row->type == SIDERAY_OPTION_SWITCH;
    const bool is_flag = row->type == SIDERAY_OPTION_FLAG;
    const bool has_two_words = std::string(row->name) == "layers" || std::string(row->name) == "poses";
    EXPECT_EQ(row->choice_count >= 2, has_choices || has_two_words) << row->name;
    EXPECT_EQ(*row->placeholder == '\0', has_choices || is_flag) << row->name;
  }
  EXPECT_EQ(sideray_option_at(sideray_option_count()), nullptr);
  EXPECT_EQ(sideray_option_find("colour"), nullptr);
  EXPECT_EQ(sideray_option_find(nullptr), nullptr);
}

TEST(OptionTable, DefaultsAreThoseOfTheStructs) {
  const Options options = Options::create().value();
  const sideray_render_options& o = options.render();
  const sideray_render_options d = sideray_render_defaults();
  EXPECT_EQ(o.width, d.width);
  EXPECT_EQ(o.height, d.height);
  EXPECT_EQ(o.samples, d.samples);
  EXPECT_EQ(o.seed, d.seed);
  EXPECT_EQ(o.reflections, d.reflections);
  EXPECT_EQ(o.ambient, d.ambient);
  EXPECT_EQ(o.taa, d.taa);
  EXPECT_EQ(o.deadline_ms, d.deadline_ms);
  EXPECT_EQ(o.reference, nullptr);
  const sideray_translucency_options t = sideray_translucency_defaults();
  EXPECT_EQ(o.translucency->method, t.method);
  EXPECT_EQ(o.translucency->layers, t.layers);
  EXPECT_EQ(o.translucency->mask, t.mask);
  EXPECT_EQ(o.translucency->match, t.match);
  EXPECT_EQ(o.translucency->match_threshold, t.match_threshold);
  EXPECT_EQ(o.translucency->cache_rate, t.cache_rate);
  EXPECT_EQ(o.translucency->second_wave, t.second_wave);
  EXPECT_EQ(o.translucency->step, t.step);
  EXPECT_EQ(o.translucency->oit, t.oit);
  EXPECT_EQ(o.translucency->light_samples, t.light_samples);
  EXPECT_EQ(o.translucency->bounces, t.bounces);
  EXPECT_EQ(sideray_reference_defaults().bounces, t.bounces);
  const sideray_shadow_options s = sideray_shadow_defaults();
  EXPECT_EQ(o.shadows->method, s.method);
  EXPECT_EQ(o.shadows->inexact, s.inexact);
  EXPECT_EQ(o.shadows->inexact_bias, s.inexact_bias);
  EXPECT_EQ(o.shadows->inexact_target, s.inexact_target);
  const sideray_pose_options p = sideray_pose_defaults();
  EXPECT_EQ(o.poses->poses, p.poses);
  EXPECT_EQ(o.poses->cull_angle_deg, p.cull_angle_deg);
  EXPECT_EQ(o.denoise, sideray_render_defaults().denoise);
}

TEST(OptionTable, EveryRowTakesItsDefaultAndItsChoices) {
  for (const sideray_option* row : rows()) {
    SCOPED_TRACE(row->name);
    Options options = Options::create().value();
    EXPECT_EQ(sideray_options_is_set(options.get(), row->name), 0);
    if (*row->default_value) {
      EXPECT_EQ(options[row->name], row->default_value);
      options.set(row->name, row->default_value);
      EXPECT_EQ(options[row->name], row->default_value);
      EXPECT_EQ(sideray_options_is_set(options.get(), row->name), 1);
      sideray_error error{};
      const bool contradicts = std::string(row->name) == "light-samples";
      EXPECT_EQ(sideray_options_check(options.get(), &error) != SIDERAY_OK, contradicts) << error.message;
    }
    for (size_t i = 0; i < row->choice_count; ++i) {
      EXPECT_EQ(refusal(options, row->name, row->choices[i]), "");
      if (row->type == SIDERAY_OPTION_CHOICE) {
        EXPECT_EQ(options[row->name], row->choices[i]);
      }
    }
    options.set(row->name, "");
    EXPECT_EQ(sideray_options_is_set(options.get(), row->name), 0);
    EXPECT_EQ(options[row->name], Options::create().value()[row->name]);
  }
}

TEST(OptionTable, ValuesOutOfRangeAreRefusedByNameAndRange) {
  const Options options = Options::create().value();
  for (const sideray_option* row : rows()) {
    SCOPED_TRACE(row->name);
    const std::string before = options[row->name], name = std::string(row->name) + ": ";
    if (row->type == SIDERAY_OPTION_TEXT) continue;
    EXPECT_THAT(refusal(options, row->name, "purple"), StartsWith(name));
    const bool has_words_alone = row->type == SIDERAY_OPTION_SWITCH || row->type == SIDERAY_OPTION_CHOICE;
    for (size_t i = 0; has_words_alone && i < row->choice_count; ++i) {
      EXPECT_THAT(refusal(options, row->name, "purple"), HasSubstr(row->choices[i]));
    }
    if (row->type == SIDERAY_OPTION_INTEGER || row->type == SIDERAY_OPTION_NUMBER) {
      for (const double outside : {row->minimum - 1, 2 * row->maximum + 1}) {
        std::ostringstream text;
        text << std::fixed << outside;
        std::string digits = text.str();
        if (row->type == SIDERAY_OPTION_INTEGER) digits.resize(digits.find('.'));
        const std::string message = refusal(options, row->name, digits);
        EXPECT_THAT(message, StartsWith(name)) << digits;
        EXPECT_THAT(message, HasSubstr("give ")) << digits;
        EXPECT_THAT(message, HasSubstr(" to ")) << digits;
      }
      EXPECT_NE(refusal(options, row->name, "nan"), "");
      EXPECT_NE(refusal(options, row->name, "1x"), "");
    }
    EXPECT_EQ(options[row->name], before) << "a failed call changes nothing";
  }
  for (const char* size : {"0x5", "5x0", "16385x1", "16384x16384", "12", "axb", "5x", "x5", "5x5x5", "5.5x5"})
    EXPECT_THAT(refusal(options, "size", size), StartsWith("size: ")) << size;
  EXPECT_THAT(refusal(options, "colour", "red"), StartsWith("colour: no such option"));
  EXPECT_THAT(refusal(options, "layer-threshold", "0"), HasSubstr("every ray of a layer is traced"));
}

TEST(OptionTable, WhatIsGoneSaysWhatToWriteInstead) {
  const Options options = Options::create().value();
  EXPECT_THAT(refusal(options, "denoise-on", "gpu"), StartsWith("denoise-on: is gone since 0.3; leave it out"));
  EXPECT_THAT(refusal(options, "radiance-format", "rgb9e5"), StartsWith("radiance-format: is gone since 0.3; "));
  EXPECT_THAT(refusal(options, "oit", "weighted"), StartsWith("oit: \"weighted\" is gone since 0.3; write sorted"));
  EXPECT_THAT(refusal(options, "oit", "front"), StartsWith("oit: \"front\" is gone since 0.3; write abuffer"));
}

TEST(OptionTable, WhatIsMappedIsReadAsWhatItIsNow) {
  Options options = Options::create().value();
  options.set("cache-rate", "quarter");
  for (const char* rate : {"temporal4", "temporal8"}) {
    EXPECT_STREQ(sideray_option_read_as("cache-rate", rate), "full");
    options.set("cache-rate", rate);
    EXPECT_EQ(options["cache-rate"], "full");
    EXPECT_EQ(options.render().translucency->cache_rate, SIDERAY_RATE_FULL);
  }
  const Options before = options;
  for (const char* value : {"auto", "0", "0.5", ""}) {
    EXPECT_STREQ(sideray_option_read_as("shading-reuse", value), "");
    options.set("shading-reuse", value);
  }
  EXPECT_STREQ(sideray_option_read_as("shading-reuse", nullptr), "");
  EXPECT_TRUE(sideray_options_equal(options.get(), before.get()));
  EXPECT_EQ(sideray_option_find("shading-reuse"), nullptr);
  EXPECT_EQ(sideray_option_read_as("cache-rate", "full"), nullptr);
  EXPECT_EQ(sideray_option_read_as("oit", "front"), nullptr) << "refused, not read";
  EXPECT_EQ(sideray_option_read_as(nullptr, "full"), nullptr);
}

TEST(OptionTable, ValuesReachTheStructs) {
  Options options = Options::create().value();
  for (const auto& [name, value] : std::vector<std::pair<const char*, const char*>>{
           {"size", "64x36"}, {"translucency", "raytraced"}, {"layers", "unlimited"}, {"match", "distance"},
           {"step", "listing"}, {"cache-rate", "quarter"}, {"second-wave", "off"},
           {"match-threshold", "0.5"}, {"mask", "none"}, {"rt-particles", "on"},
           {"oit", "peel"}, {"shadows", "map"}, {"inexact", "tmin"}, {"inexact-bias", "2"}, {"inexact-target", "bit"},
           {"poses", "7"}, {"cull-angle", "3"}, {"reflections", "on"}, {"ambient", "ao"}, {"samples", "5"}, {"seed", "9"},
           {"deadline", "12"}, {"taa", "on"}})
    options.set(name, value);
  const sideray_render_options& o = options.render();
  EXPECT_EQ(o.width * 1000 + o.height, 64036u);
  EXPECT_EQ(o.translucency->method, SIDERAY_TRANSLUCENCY_RAYTRACED);
  EXPECT_EQ(o.translucency->layers, 0u);
  EXPECT_EQ(o.translucency->match, SIDERAY_MATCH_DISTANCE);
  EXPECT_EQ(o.translucency->step, SIDERAY_STEP_LISTING);
  EXPECT_EQ(o.translucency->cache_rate, SIDERAY_RATE_QUARTER);
  EXPECT_EQ(o.translucency->second_wave, 0);
  EXPECT_EQ(o.translucency->match_threshold, 0.5f);
  EXPECT_EQ(o.translucency->mask, SIDERAY_NO_MASK);
  EXPECT_EQ(o.translucency->particles, 1);
  EXPECT_EQ(o.translucency->oit, SIDERAY_OIT_PEEL);
  EXPECT_EQ(o.shadows->method, SIDERAY_SHADOWS_MAP);
  EXPECT_EQ(o.shadows->inexact, SIDERAY_INEXACT_TMIN);
  EXPECT_EQ(o.shadows->inexact_bias, 2.0f);
  EXPECT_EQ(o.shadows->inexact_target, SIDERAY_TARGET_BIT);
  EXPECT_EQ(o.poses->poses, 7u);
  EXPECT_EQ(o.poses->cull_angle_deg, 3.0f);
  EXPECT_EQ(o.reflections + o.ambient + o.taa, 3);
  EXPECT_EQ(o.samples, 5u);
  EXPECT_EQ(o.seed, 9u);
  EXPECT_EQ(o.deadline_ms, 12.0f);
  options.set("poses", "all");
  EXPECT_EQ(options.render().poses->poses, SIDERAY_POSES_ALL);
  options.set("poses", "rest");
  EXPECT_EQ(options.render().poses->poses, SIDERAY_POSES_REST);
  options.set("denoise", "off");
  EXPECT_EQ(options.render().denoise, 0);
  Options reference = Options::create().value();
  for (const auto& [name, value] : {std::pair("reference", "true"), std::pair("light-samples", "3"),
                                    std::pair("refraction", "off")})
    reference.set(name, value);
  ASSERT_NE(reference.render().reference, nullptr);
  EXPECT_EQ(reference.render().reference->light_samples, 3u);
  EXPECT_EQ(reference.render().reference->refraction, 0);
  reference.set("refraction", "");
  EXPECT_EQ(reference.render().reference->refraction, 1);
}

TEST(OptionTable, AQualityHasValuesForWhatIsNotGiven) {
  const auto with = [](std::initializer_list<std::pair<const char*, const char*>> given) {
    Options options = Options::create().value();
    for (const auto& [name, value] : given) options.set(name, value);
    return options;
  };
  const Options none = with({}), balanced = with({{"quality", "balanced"}});
  EXPECT_NE(sideray_options_equal(none.get(), balanced.get()), 0) << "balanced has every default";
  const Options draft = with({{"quality", "draft"}});
  EXPECT_EQ(draft["quality"], "draft");
  for (const auto& [name, value] : {std::pair("layers", "2"), std::pair("refraction", "off"), std::pair("shadows", "map"),
                                    std::pair("poses", "rest"), std::pair("reflections", "off"), std::pair("ambient", "off")})
    EXPECT_EQ(draft[name], value);
  EXPECT_EQ(draft.render().translucency->layers, 2u);
  EXPECT_EQ(draft.render().shadows->method, SIDERAY_SHADOWS_MAP);
  EXPECT_EQ(sideray_options_is_set(draft.get(), "shadows"), 0);
  EXPECT_EQ(with({{"quality", "best"}}).render().translucency->ray_reuse, 0.0f);
  for (const auto& [method, layers] : {std::pair("hybrid", "8"), std::pair("raytraced", "unlimited"), std::pair("raster", "")})
    EXPECT_EQ(with({{"quality", "best"}, {"translucency", method}})["layers"], layers) << method;
  // What is given wins, in either order, and giving it back leaves what the set has.
  Options before = with({{"shadows", "exact"}, {"quality", "draft"}}), after = with({{"quality", "draft"}, {"shadows", "exact"}});
  EXPECT_NE(sideray_options_equal(before.get(), after.get()), 0);
  EXPECT_EQ(after["shadows"], "exact");
  after.set("shadows", "");
  EXPECT_EQ(after["shadows"], "map");
  after.set("quality", "");
  EXPECT_NE(sideray_options_equal(after.get(), none.get()), 0);
  EXPECT_EQ(contradiction({{"quality", "draft"}, {"translucency", "raytraced"}, {"layers", "64"}}), "");
  EXPECT_THAT(contradiction({{"quality", "best"}, {"reference", "true"}}), HasSubstr("'quality'"));
}

TEST(OptionTable, CopiesAreTheirOwn) {
  Options first = Options::create().value();
  first.set("translucency", "raytraced");
  Options second = first;
  EXPECT_EQ(second["translucency"], "raytraced");
  second.set("translucency", "raster");
  EXPECT_EQ(first.render().translucency->method, SIDERAY_TRANSLUCENCY_RAYTRACED);
  EXPECT_EQ(second.render().translucency->method, SIDERAY_TRANSLUCENCY_RASTER);
}

TEST(OptionTable, OthersDecideWhatIsLeftOpen) {
  Options options = Options::create().value();
  EXPECT_EQ(options["layers"], "4");
  options.set("translucency", "raytraced");
  EXPECT_EQ(options["layers"], "2");
  options.set("translucency", "raster");
  EXPECT_EQ(options["layers"], "");
  EXPECT_EQ(options["taa"], "off");
  options.set("translucency", "");
  options.set("reference", "true");
  EXPECT_EQ(options["translucency"], "reference");
  EXPECT_EQ(options["shadows"], "exact");
  options.set("shadows", "off");
  EXPECT_EQ(options["shadows"], "off");
  EXPECT_EQ(sideray_options_get(options.get(), "colour"), nullptr);
}

TEST(OptionTable, RayReuseIsLeftToThePlan) {
  Options options = Options::create().value();
  EXPECT_EQ(options["ray-reuse"], "auto");
  EXPECT_EQ(options.render().translucency->ray_reuse, SIDERAY_RAY_REUSE_AUTO);
  const auto with = [&](const char* name, const char* value) {
    Options changed = options;
    changed.set(name, value);
    return changed["ray-reuse"];
  };
  EXPECT_EQ(with("cache-rate", "checkerboard"), "0");
  EXPECT_EQ(with("oit", "peel"), "auto");
  options.set("translucency", "raytraced");
  EXPECT_EQ(with("refraction", "on"), "auto") << "the scene decides whether anything is refracted";
  EXPECT_EQ(with("cache-rate", "checkerboard"), "auto") << "nothing is cached";
  options.set("ray-reuse", "0.125");
  EXPECT_EQ(options.render().translucency->ray_reuse, 0.125f);
}

TEST(OptionTable, RaysOfOpaqueSurfacesAreLeftToThePlan) {
  for (const char* name : {"ambient", "reflections"}) {
    SCOPED_TRACE(name);
    const bool ambient = std::string(name) == "ambient";
    Options options = Options::create().value();
    const auto value = [&] {
      const sideray_render_options& o = options.render();
      return std::string(name) == "ambient" ? o.ambient : o.reflections;
    };
    EXPECT_EQ(options[name], "auto");
    EXPECT_EQ(value(), -1);
    for (const auto& [text, number] : {std::pair(ambient ? "ao" : "on", 1), std::pair("off", 0), std::pair("auto", -1)}) {
      options.set(name, text);
      EXPECT_EQ(options[name], text);
      EXPECT_EQ(value(), number);
    }
    EXPECT_THAT(refusal(options, name, "1"), HasSubstr(ambient ? "one of auto, off, ao, bounce" : "one of auto, on, off"));
    options.set("reference", "true");
    EXPECT_EQ(options[name], "off") << "references have nothing to choose";
  }
}

// In scenes of which it is known what auto comes to, it is the same as that.
TEST(OptionTable, RaysOfOpaqueSurfacesAreReducedToWhatTheSceneMakesOfThem) {
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  facts.glossy_objects = facts.lit_lights = 1;
  facts.has_environment = 1;
  for (const bool is_traced : {true, false}) {
    facts.auto_ao = facts.auto_bounce = facts.auto_reflections = is_traced;
    for (const char* name : {"ambient", "reflections"}) {
      SCOPED_TRACE(name);
      const auto reduced = [&](const char* text) {
        Options options = Options::create().value();
        options.set(name, text);
        EXPECT_EQ(sideray_options_reduce(options.get(), &facts, nullptr), SIDERAY_OK);
        return options;
      };
      const Options automatic = reduced("");
      const char* traced = std::string(name) == "ambient" ? "bounce" : "on";
      EXPECT_TRUE(sideray_options_equal(automatic.get(), reduced(is_traced ? traced : "off").get()));
      EXPECT_FALSE(sideray_options_equal(automatic.get(), reduced(is_traced ? "off" : traced).get()));
    }
    const auto shortcut = [&](const char* wanted) {
      sideray_shortcuts* list = nullptr;
      const Options options = Options::create().value();
      EXPECT_EQ(sideray_shortcuts_create(options.get(), &facts, &list, nullptr), SIDERAY_OK);
      bool found = false;
      for (size_t i = 0; i < sideray_shortcuts_count(list); ++i)
        found |= std::string(sideray_shortcuts_at(list, i)->name) == wanted && sideray_shortcuts_at(list, i)->taken;
      sideray_shortcuts_release(list);
      return found;
    };
    EXPECT_EQ(shortcut("ambient"), is_traced);
  }
}

TEST(OptionTable, RowsAreReadAndApplyWhereTheySay) {
  Options options = Options::create().value();
  const auto reads = [&](const char* name) { return sideray_options_reads(options.get(), name) != 0; };
  const auto applies = [&](const char* name) { return sideray_options_applies(options.get(), name, nullptr) != 0; };
  for (const char* name : {"ray-traced", "layers", "match", "match-threshold", "second-wave", "whole-pixels", "oit", "poses"})
    EXPECT_TRUE(reads(name)) << name;
  for (const char* name : {"cache-rate", "oit", "mask"}) {
    EXPECT_TRUE(applies("whole-pixels")) << name;
    options.set(name, std::string(name) == "oit" ? "peel" : std::string(name) == "mask" ? "stencil" : "quarter");
    EXPECT_FALSE(applies("whole-pixels")) << name;
    options.set(name, "");
  }
  for (const char* name : {"rt-particles", "light-samples"}) EXPECT_FALSE(reads(name)) << name;
  for (const char* name : {"match-threshold", "second-wave", "inexact-bias"})
    EXPECT_FALSE(applies(name)) << name;
  options.set("match", "distance");
  options.set("cache-rate", "quarter");
  options.set("inexact", "tmin");
  for (const char* name : {"match-threshold", "second-wave", "inexact-bias"})
    EXPECT_TRUE(applies(name)) << name;
  options.set("layers", "0");
  EXPECT_TRUE(reads("match"));
  EXPECT_FALSE(applies("match")) << "there are none to match";
  options.set("layers", "");
  const char* reason = nullptr;
  options.set("translucency", "raster");
  EXPECT_EQ(sideray_options_applies(options.get(), "match", &reason), 0);
  EXPECT_STREQ(reason, "only hybrid translucency has layers");
  EXPECT_EQ(sideray_options_applies(options.get(), "oit", &reason), 1);
  EXPECT_STREQ(reason, "raster and hybrid");
  EXPECT_EQ(sideray_options_applies(options.get(), "colour", &reason), 0);
  EXPECT_STREQ(reason, "no such option");
}

TEST(OptionTable, ContradictionsNameBoth) {
  for (const sideray_option* row : rows()) {
    const std::string name = row->name;
    if (name == "reference" || name == "check" || *row->default_value == '\0') continue;
    static const std::set<std::string> allowed{"size", "refraction", "bounces", "reflections", "ambient",
                                               "samples", "light-samples", "caustics", "seed"};
    const std::string message = contradiction({{"reference", "true"}, {name, row->default_value}});
    EXPECT_EQ(message.empty(), allowed.contains(name)) << name;
    if (!message.empty()) {
      EXPECT_THAT(message, StartsWith("reference: contradicts '" + name + "'"));
    }
  }
  for (const char* name : {"shadows", "denoise", "taa"}) EXPECT_EQ(contradiction({{"reference", "true"}, {name, "off"}}), "");
  EXPECT_THAT(contradiction({{"translucency", "raytraced"}, {"check", "true"}}), StartsWith("check: only hybrid"));
  EXPECT_THAT(contradiction({{"reference", "true"}, {"check", "true"}}), StartsWith("check: only hybrid"));
  EXPECT_THAT(contradiction({{"ray-reuse", "0.1"}, {"cache-rate", "quarter"}}), HasSubstr("cache rate"));
  EXPECT_EQ(contradiction({{"translucency", "raytraced"}, {"ray-reuse", "0.1"}, {"refraction", "on"}}), "");
  EXPECT_EQ(contradiction({{"ray-reuse", "auto"}, {"cache-rate", "quarter"}}), "");
  for (const auto& [name, value] : std::map<std::string, std::string>{
           {"mask", "stencil"}, {"cache-rate", "quarter"}, {"oit", "peel"}}) {
    EXPECT_THAT(contradiction({{"whole-pixels", "on"}, {name, value}}),
                AllOf(StartsWith("whole-pixels on: "), HasSubstr("'" + name + "'")));
    EXPECT_EQ(contradiction({{name, value}}), "") << "the default has no pixel whole, and no more to say";
    EXPECT_EQ(contradiction({{"whole-pixels", "off"}, {name, value}}), "");
    EXPECT_EQ(contradiction({{"whole-pixels", "on"}, {name, value}, {"translucency", "raster"}}), "");
    EXPECT_EQ(contradiction({{"whole-pixels", "on"}, {name, value}, {"layers", "0"}}), "");
  }
  for (const char* order : {"sorted", "abuffer"})
    EXPECT_EQ(contradiction({{"whole-pixels", "on"}, {"oit", order}}), "");
  EXPECT_THAT(contradiction({{"taa", "on"}, {"samples", "2"}}), StartsWith("taa on: "));
  EXPECT_THAT(contradiction({{"translucency", "reference"}, {"deadline", "5"}}), StartsWith("deadline: "));
  EXPECT_THAT(contradiction({{"light-samples", "5"}}), HasSubstr("'reference' or 'translucency reference'"));
  EXPECT_THAT(contradiction({{"layers", "9"}}), HasSubstr("0 to 8"));
  EXPECT_THAT(contradiction({{"layers", "unlimited"}}), HasSubstr("0 to 8"));
  for (const char* layers : {"0", "auto"})
    EXPECT_THAT(contradiction({{"translucency", "raytraced"}, {"layers", layers}}), HasSubstr("1 to 64"));
  EXPECT_EQ(contradiction({{"translucency", "raster"}, {"layers", "64"}}), "");
}

// docs/cli.md has every option, by its full name.
TEST(OptionTable, TheManualHasEveryRow) {
  std::ostringstream text;
  text << std::ifstream(SIDERAY_SOURCE_DIR "/docs/cli.md").rdbuf();
  for (const sideray_option* row : rows())
    EXPECT_NE(text.str().find((row->diagnostic ? "| `" : "--") + std::string(row->name)), std::string::npos) << row->name;
}

TEST(OptionTable, WhatIsNotGivenIsRefused) {
  sideray_error error{};
  EXPECT_EQ(sideray_options_create(nullptr, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(sideray_options_set(nullptr, "size", "1x1", &error), SIDERAY_INVALID_ARGUMENT);
  const Options options = Options::create().value();
  EXPECT_EQ(sideray_options_set(options.get(), nullptr, "1x1", &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(sideray_options_set(options.get(), "seed", nullptr, &error), SIDERAY_OK);
  sideray_options_release(nullptr);
}

}  // namespace
}  // namespace sideray
