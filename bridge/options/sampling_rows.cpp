// Defines options for the picture's size, its preset, its samples, and what is exact as a whole.
#include <cstdint>

#include "bridge/base/lighting.h"
#include "bridge/options/option_row.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr NumberRange light_sample_range{1, most_light_samples}, bounce_range{1, most_bounces};

const char* unless_exact(const OptionValues& v) {
  return v.is_exact() ? nullptr : "nothing is sampled without a reference";
}

// Returns whether the picture is already an average.
bool is_average(const OptionValues& v) {
  return v.picture.samples > 1 || v.is_exact();
}

OptionRow taa_row() {
  OptionRow row = option_switch("taa", "", "anti-aliasing over time [on in sequences]");
  row.option.applies = "sequences";
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "off";
  bind<&OptionValues::picture, &sideray_render_options::taa>(row);
  row.past = [](const OptionValues& v) { return v.picture.taa ? SIDERAY_PAST_AVERAGED : SIDERAY_PAST_NONE; };
  row.idle = [](const OptionValues& v) {
    return is_average(v) ? "pictures of several samples and references are averages already" : nullptr;
  };
  row.check = [](const OptionValues& v, const OptionValue& value) {
    if (value.on() && is_average(v))
      fail(SIDERAY_INVALID_ARGUMENT,
           "taa on: pictures of several samples and references are averages already; leave it out");
  };
  row.decided = [](const OptionValues& v, const std::string&) {
    return std::string(v.picture.taa && !is_average(v) ? "on" : "off");
  };
  return row;
}

OptionRow samples_row() {
  OptionRow row = option_integer("samples", "N", {1, 4096}, "1", "camera positions per pixel, averaged");
  row.option.group = most_used;
  row.option.cost = SIDERAY_COST_TRADE;
  bind<&OptionValues::picture, &sideray_render_options::samples>(row);
  return row;
}

OptionRow light_samples_row() {
  OptionRow row = option_integer("light-samples", "M", light_sample_range, "64",
                                 "references: samples of lights and materials per position");
  row.option.applies = "references";
  row.option.cost = SIDERAY_COST_TRADE;
  row.unread = unless_exact;
  row.check = [](const OptionValues& v, const OptionValue&) {
    if (!v.is_exact())
      fail(SIDERAY_INVALID_ARGUMENT,
           "light-samples: nothing is sampled; give 'reference' or 'translucency reference' too");
  };
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.light_samples = value.whole();
    v.reference.light_samples = value.whole();
  };
  row.load = [](const OptionValues& v) {
    return v.is_exact() ? double(v.is_reference ? v.reference.light_samples : v.translucency.light_samples) : 1.0;
  };
  return row;
}

OptionRow bounces_row() {
  OptionRow row = option_integer("bounces", "N|unlimited", bounce_range, "1",
                                 "references: how often light may be reflected");
  row.words = {{"unlimited", 0}};
  row.option.applies = "references";
  row.option.cost = SIDERAY_COST_PICTURE;
  row.unread = unless_exact;
  row.check = [](const OptionValues& v, const OptionValue& value) {
    if (!v.is_exact() && value.whole() != 1)
      fail(SIDERAY_INVALID_ARGUMENT,
           "bounces: only references follow light further; give 'reference' or 'translucency reference' too");
  };
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.translucency.bounces = value.whole();
    v.reference.bounces = value.whole();
  };
  row.load = [](const OptionValues& v) {
    return v.is_exact() ? double(v.is_reference ? v.reference.bounces : v.translucency.bounces) : 1.0;
  };
  return row;
}

OptionRow caustics_row() {
  OptionRow row = option_switch("caustics", "off", "--reference: glass bends the light of lamps");
  row.option.applies = "references";
  row.option.cost = SIDERAY_COST_PICTURE;
  row.unread = unless_exact;
  row.check = [](const OptionValues& v, const OptionValue& value) {
    if (value.on() && v.reference.bounces == 1)
      fail(SIDERAY_INVALID_ARGUMENT, "caustics: only paths of a reference have them; give 'reference' and 'bounces' too");
  };
  bind<&OptionValues::reference, &sideray_reference_options::caustics>(row);
  return row;
}

OptionRow seed_row() {
  OptionRow row = option_integer("seed", "N", {0, UINT32_MAX}, "1", "seed of the random numbers");
  row.option.cost = SIDERAY_COST_PICTURE;
  row.is_random = true;
  bind<&OptionValues::picture, &sideray_render_options::seed>(row);
  return row;
}

OptionRow deadline_row() {
  OptionRow row = option_number("deadline", "MS", {1e-3, 1e9}, "", "until 0.4: milliseconds after which no more rays start");
  row.option.advanced = 1;
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "";
  bind<&OptionValues::picture, &sideray_render_options::deadline_ms>(row);
  row.in_structs = {0};
  row.check = [](const OptionValues& v, const OptionValue&) {
    if (v.is_exact())
      fail(SIDERAY_INVALID_ARGUMENT,
           "deadline: 'translucency reference' takes the time that it needs; leave one of them out");
  };
  return row;
}

OptionRow budget_row() {
  OptionRow row = option_number("budget", "MS", {1e-3, 1e9}, "", "milliseconds that rays may add to a frame");
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "";
  bind<&OptionValues::picture, &sideray_render_options::budget_ms>(row);
  row.in_structs = {0};
  row.checks_structs = true;
  row.check = [](const OptionValues& v, const OptionValue& value) {
    if (value.number > 0.0 && v.picture.deadline_ms > 0.0f)
      fail(SIDERAY_INVALID_ARGUMENT, "budget: there is a deadline too; leave 'deadline' out");
    if (value.number > 0.0 && v.is_exact())
      fail(SIDERAY_INVALID_ARGUMENT,
           "budget: 'translucency reference' takes the time that it needs; leave one of them out");
  };
  return row;
}

OptionRow reference_row() {
  OptionRow row = option_flag("reference", "everything by rays, exact and without limits");
  row.option.group = most_used;
  row.option.part = "reference";
  row.option.cost = SIDERAY_COST_TRADE;
  row.store = [](OptionValues& v, const OptionValue& value) { v.is_reference = value.on(); };
  return row;
}

OptionRow check_row() {
  OptionRow row = option_flag("check", "hybrid: the statistics count wrong layers");
  row.option.diagnostic = 1;
  row.option.part = "translucency";
  row.option.applies = "hybrid";
  row.option.cost = SIDERAY_COST_NONE;
  row.unread = [](const OptionValues& v) { return v.is_hybrid() ? nullptr : "only hybrid translucency has layers"; };
  row.check = [](const OptionValues& v, const OptionValue& value) {
    if (value.on() && !v.is_hybrid())
      fail(SIDERAY_INVALID_ARGUMENT,
           "check: only hybrid translucency has layers to check; choose it, or leave 'check' out");
  };
  row.checks_structs = true;
  bind<&OptionValues::translucency, &sideray_translucency_options::check>(row);
  return row;
}

OptionRow size_row() {
  OptionRow row;
  row.option.name = "size";
  row.option.type = SIDERAY_OPTION_SIZE;
  row.option.placeholder = "WxH";
  row.option.minimum = 1;
  row.option.maximum = 16384;
  row.option.default_value = "1280x720";
  row.option.cost = SIDERAY_COST_PICTURE;
  row.option.group = most_used;
  row.option.help = "width and height of the picture in pixels";
  row.store = [](OptionValues& v, const OptionValue& value) {
    v.picture.width = value.width;
    v.picture.height = value.height;
  };
  return row;
}

OptionRow quality_row() {
  OptionRow row = option_choice("quality",
                                {{"draft", static_cast<int>(Quality::draft)},
                                 {"balanced", static_cast<int>(Quality::balanced)},
                                 {"best", static_cast<int>(Quality::best)}},
                                "balanced", "values of the options that are not given");
  row.option.group = most_used;
  row.option.cost = SIDERAY_COST_TRADE;
  row.beside_reference = "";
  row.unread = [](const OptionValues& v) {
    return v.is_reference ? "a reference has no options that a set of values changes" : nullptr;
  };
  row.store = [](OptionValues& v, const OptionValue& value) { v.quality = static_cast<Quality>(value.whole()); };
  return row;
}

}  // namespace

// `quality` precedes the options that it sets.
std::vector<OptionRow> leading_rows() {
  return {size_row(), quality_row()};
}

std::vector<OptionRow> sampling_rows() {
  return under_title("Accuracy", {taa_row(), samples_row(), light_samples_row(), bounces_row(), caustics_row(),
                                  seed_row(), budget_row(), deadline_row(), reference_row(), check_row()});
}

}  // namespace sideray::bridge
