// Tests the built-in lists of `chart`: as long as the scene needs, without duplicates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "lab/chart/configurations.h"

namespace sideray::lab {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

SweepScene interior() {
  SweepScene scene;
  scene.translucent_objects = 60;
  scene.traceable_objects = 58;
  scene.layered_objects = 50;
  scene.has_particles = scene.has_gloss = scene.has_environment = scene.has_fragment_lists = true;
  scene.lights = 4;
  scene.smallest_angle_deg = 0.1;
  return scene;
}

SweepScene forest() {
  SweepScene scene;
  scene.swaying_objects = 2000;
  scene.swaying_copies = 900;
  scene.lights = 1;
  scene.has_cut_outs = scene.has_gloss = scene.has_environment = scene.has_fragment_lists = true;
  scene.smallest_angle_deg = 0.1;
  return scene;
}

SweepScene everything() {
  SweepScene scene = interior();
  const SweepScene plants = forest();
  scene.swaying_objects = plants.swaying_objects;
  scene.swaying_copies = plants.swaying_copies;
  scene.has_cut_outs = scene.is_sequence = true;
  return scene;
}

size_t count_of(const DefaultSweep& sweep, const Configuration& part) {
  return static_cast<size_t>(std::count_if(
      sweep.configurations.begin(), sweep.configurations.end(),
      [&](const Configuration& c) { return std::includes(c.begin(), c.end(), part.begin(), part.end()); }));
}

TEST(DefaultSweep, AScenesOwnListHasTwentyToSixtyPoints) {
  for (const auto& [sweep, scene] : {std::pair(Sweep::translucency, interior()), std::pair(Sweep::shadows, forest()),
                                     std::pair(Sweep::all, interior()), std::pair(Sweep::all, forest()),
                                     std::pair(Sweep::translucency, everything()),
                                     std::pair(Sweep::shadows, everything()), std::pair(Sweep::all, everything())}) {
    const size_t points = default_sweep(sweep, scene).configurations.size();
    EXPECT_GE(points, 20u) << static_cast<int>(sweep);
    EXPECT_LE(points, 60u) << static_cast<int>(sweep);
  }
}

TEST(DefaultSweep, NoPointIsThereTwice) {
  for (const Sweep sweep : {Sweep::translucency, Sweep::shadows, Sweep::all})
    for (const SweepScene& scene : {interior(), forest(), everything(), SweepScene{}}) {
      const std::vector<Configuration> list = default_sweep(sweep, scene).configurations;
      EXPECT_EQ(std::set<Configuration>(list.begin(), list.end()).size(), list.size());
    }
}

TEST(DefaultSweep, HoldsBothBaselines) {
  const DefaultSweep glass = default_sweep(Sweep::translucency, interior());
  for (const char* mode : {"raster", "off", "raytraced", "hybrid", "reference"})
    EXPECT_GE(count_of(glass, {{"translucency", mode}}), 1u) << mode;
  for (const char* events : {"1", "2", "4", "8", "unlimited"})
    EXPECT_GE(count_of(glass, {{"translucency", "raytraced"}, {"layers", events}}), 1u) << events;
  const DefaultSweep plants = default_sweep(Sweep::shadows, forest());
  for (const char* shadows : {"off", "map", "exact", "inexact"})
    EXPECT_GE(count_of(plants, {{"shadows", shadows}}), 1u) << shadows;
  EXPECT_EQ(count_of(plants, {{"shadows", "exact"}, {"poses", "all"}}), 2u);
}

// The union of both lists has common points once, and leaves out the finest points if it is too long.
TEST(DefaultSweep, AllIsBoth) {
  const DefaultSweep all = default_sweep(Sweep::all, everything());
  for (const char* shadows : {"off", "map", "exact", "inexact"})
    EXPECT_GE(count_of(all, {{"shadows", shadows}}), 1u) << shadows;
  for (const char* mode : {"raster", "raytraced"}) EXPECT_GE(count_of(all, {{"translucency", mode}}), 1u);
  EXPECT_THAT(all.configurations, Contains(Configuration{{"translucency", "hybrid"}, {"layers", "4"}}));
  EXPECT_THAT(all.configurations, Not(Contains(Configuration{{"shadows", "inexact"}, {"inexact", "restpose"}})))
      << "these are the defaults, as hybrid with 4 layers is";
  EXPECT_THAT(all.left_out, Contains(HasSubstr("60 of")));
}

TEST(DefaultSweep, GlassThatIsNotThereIsNotSwept) {
  const DefaultSweep opaque = default_sweep(Sweep::translucency, forest());
  EXPECT_EQ(opaque.configurations, (std::vector<Configuration>{{{"translucency", "raster"}}}));
  EXPECT_THAT(opaque.left_out, Contains(HasSubstr("no translucent object")));
  SweepScene rough = interior();
  rough.layered_objects = 0;
  const DefaultSweep without_layers = default_sweep(Sweep::translucency, rough);
  EXPECT_EQ(count_of(without_layers, {{"translucency", "hybrid"}}), 0u);
  EXPECT_GE(count_of(without_layers, {{"translucency", "raytraced"}}), 5u);
  EXPECT_THAT(without_layers.left_out, Contains(HasSubstr("no hybrid")));
  // Here the default draws as raster, and inexact shadows equal exact ones.
  const DefaultSweep all = default_sweep(Sweep::all, rough);
  EXPECT_THAT(all.configurations, Contains(Configuration{{"translucency", "raster"}}));
  EXPECT_THAT(all.configurations, Not(Contains(Configuration{{"shadows", "exact"}})));
}

// More than a ray can hit is the same as all that it meets.
TEST(DefaultSweep, StopsAtWhatARayMeets) {
  SweepScene panes = interior();
  panes.most_layers = panes.most_events = 4;
  const DefaultSweep sweep = default_sweep(Sweep::translucency, panes);
  EXPECT_EQ(count_of(sweep, {{"layers", "8"}}), 0u);
  EXPECT_EQ(count_of(sweep, {{"layers", "unlimited"}}), 0u);
  EXPECT_GE(count_of(sweep, {{"layers", "4"}}), 2u);
  EXPECT_THAT(sweep.left_out, Contains(HasSubstr("than a ray can hit")));
  SweepScene three = panes;
  three.most_layers = three.most_events = 3;
  EXPECT_GE(count_of(default_sweep(Sweep::translucency, three), {{"layers", "4"}}), 1u) << "the first that holds all";
  SweepScene single = panes;
  single.most_layers = single.most_events = 1;
  single.has_particles = false;
  const DefaultSweep one = default_sweep(Sweep::translucency, single);
  EXPECT_EQ(count_of(one, {{"oit", "peel"}}), 0u);
  EXPECT_EQ(count_of(one, {{"step", "retrace"}}), 0u);
  EXPECT_EQ(count_of(one, {{"layers", "2"}}), 0u);
}

TEST(DefaultSweep, WhatStandsStillHasOnePose) {
  SweepScene still = forest();
  still.swaying_objects = still.swaying_copies = 0;
  still.has_cut_outs = false;
  const DefaultSweep sweep = default_sweep(Sweep::shadows, still);
  EXPECT_EQ(count_of(sweep, {{"shadows", "inexact"}}), 0u);
  for (const char* poses : {"rest", "all"}) EXPECT_EQ(count_of(sweep, {{"poses", poses}}), 0u);
  EXPECT_GE(count_of(sweep, {{"shadows", "exact"}}), 3u);
  EXPECT_THAT(sweep.left_out, Contains(HasSubstr("wind moves nothing")));
}

TEST(DefaultSweep, LightsGlossSkyAndSizeDecide) {
  SweepScene bare;
  const DefaultSweep dark = default_sweep(Sweep::shadows, bare);
  EXPECT_EQ(dark.configurations, (std::vector<Configuration>{{{"shadows", "off"}}}));
  for (const char* reason : {"no light", "no --reflections", "no --ambient"})
    EXPECT_THAT(dark.left_out, Contains(HasSubstr(reason)));
  bare.lights = 1;
  const DefaultSweep lit = default_sweep(Sweep::shadows, bare);
  EXPECT_EQ(count_of(lit, {{"cull-angle", "2"}}), 0u);
  EXPECT_THAT(lit.left_out, Contains(HasSubstr("--cull-angle")));
  bare.smallest_angle_deg = 3;
  EXPECT_EQ(count_of(default_sweep(Sweep::shadows, bare), {{"cull-angle", "2"}}), 0u);
  EXPECT_EQ(count_of(default_sweep(Sweep::shadows, bare), {{"cull-angle", "4"}}), 1u);
}

TEST(DefaultSweep, TemporalMethodsNeedASequence) {
  SweepScene scene = everything();
  scene.is_sequence = false;
  for (const Sweep sweep : {Sweep::translucency, Sweep::shadows}) {
    EXPECT_EQ(count_of(default_sweep(sweep, scene), {{"taa", "off"}}), 0u);
    EXPECT_GE(count_of(default_sweep(sweep, everything()), {{"taa", "off"}}), 1u);
  }
}

}  // namespace
}  // namespace sideray::lab
