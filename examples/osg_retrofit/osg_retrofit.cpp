// Runs the engine before and after the retrofit (osg_retrofit --help), and gives pictures, a window, or times.
#include <osgDB/WriteFile>
#include <osgGA/TrackballManipulator>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine.h"
#include "retrofit.h"
#include "rules.h"

namespace {

constexpr double frame_s = 1.0 / 30.0;

struct Options {
  EngineSettings engine{.scene = SIDERAY_RETROFIT_SCENE};
  RetrofitSettings retrofit;
  bool sideray = false, late = false, no_shadows = false, stats = false;
  std::string output, size = "640x360", view = "terrace";
  int frames = 0;
  double time_s = 0;
};

struct View {
  const char* name;
  osg::Vec3d eye, target;
  double fov_deg;
};
constexpr const char* view_names[] = {"terrace", "table"};
const View views[] = {{view_names[0], {2.35, 1.45, -7.9}, {-0.5, 1.2, -4.6}, 50.0},
                      {view_names[1], {1.95, 1.18, -6.75}, {1.02, 0.86, -5.8}, 46.0}};

void parse_size(Options& o) {
  if (std::sscanf(o.size.c_str(), "%dx%d", &o.engine.width, &o.engine.height) != 2 || o.engine.width < 16 ||
      o.engine.height < 16 || o.engine.width > 8192 || o.engine.height > 8192)
    throw std::runtime_error("--size " + o.size + ": give WIDTHxHEIGHT, 16 to 8192 each, for example 640x360");
}

Options parse(CLI::App& app, int argc, char** argv) {
  Options o;
  app.add_option("scene", o.engine.scene, "A file that OpenSceneGraph reads (the terrace)");
  app.add_flag("--sideray", o.sideray, "Retrofitted: ray-traced glass and shadows");
  app.add_flag("--late", o.late, "Show the newest answers there are instead of waiting for this frame's");
  app.add_flag("--no-shadows", o.no_shadows, "Glass alone");
  app.add_option("--layers", o.retrofit.layers, "Glass surfaces a pixel that rays shade")->check(CLI::Range(1, 8));
  app.add_option("--budget", o.retrofit.budget_ms, "Milliseconds that rays may add to a frame; 0 = no limit")
      ->check(CLI::Range(0.0f, 1e6f));
  app.add_option("--threads", o.retrofit.threads, "That trace; 0 = all");
  app.add_option("--view", o.view, "Where the camera stands")->check(CLI::IsMember({view_names[0], view_names[1]}));
  app.add_option("--size", o.size, "WIDTHxHEIGHT");
  app.add_option("--context", o.engine.context, "auto or surfaceless or device: headless, by EGL; or a window")
      ->check(CLI::IsMember({"auto", "surfaceless", "device", "window"}));
  app.add_option("--time", o.time_s, "Seconds that the scene has run for");
  app.add_option("--frames", o.frames, "Draw so many, then end")->check(CLI::Range(1, 1000000));
  app.add_flag("--stats", o.stats,
               "Times of --frames frames each: without the service, with it, late, and within budgets");
  app.add_option("-o,--output", o.output, "PNG of the last frame");
  app.parse(argc, argv);
  parse_size(o);
  if (o.stats && o.frames == 0) o.frames = 20;
  if (o.frames == 0 && (o.engine.context != "window" || !o.output.empty())) o.frames = 1;
  o.retrofit.wait = !o.late;
  o.retrofit.shadows = !o.no_shadows;
  return o;
}

const View& view_named(const std::string& name) {
  return *std::find_if(std::begin(views), std::end(views), [&](const View& v) { return v.name == name; });
}

struct FrameTime {
  double all_ms, follow_ms;
};

// Draws one frame of the engine; `adapter` follows the objects that the engine moved.
FrameTime draw_frame(Engine& engine, sideray_osg::SceneAdapter* adapter, double time_s) {
  using Clock = std::chrono::steady_clock;
  const auto ms = [](Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); };
  const Clock::time_point start = Clock::now();
  engine.update(time_s);
  const Clock::time_point updated = Clock::now();
  if (adapter) adapter->update();
  const Clock::time_point followed = Clock::now();
  engine.draw();
  return {ms(Clock::now() - start), ms(followed - updated)};
}

double quantile(std::vector<double> values, size_t quarter) {
  std::sort(values.begin(), values.end());
  return values[(values.size() - 1) * quarter / 4];
}

// Holds percentages of glass and opaque pixels by the age of their answers, and the times without a new answer.
struct Answers {
  std::vector<double> now, older, none, mask_none, gaps_ms;
  uint64_t oldest = 0;

  void add(const sideray_frame_stats& s) {
    const auto percent = [](uint64_t part, uint64_t all) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(all, 1));
    };
    now.push_back(percent(s.pixels_masked - s.pixels_late - s.pixels_older, s.pixels_masked));
    older.push_back(percent(s.pixels_older, s.pixels_masked));
    none.push_back(percent(s.pixels_late, s.pixels_masked));
    mask_none.push_back(percent(s.mask_pixels_late, s.pixels_total));
    oldest = std::max(oldest, s.answer_age);
  }
  void print() const {
    if (now.empty()) return;
    std::printf(" %6.1f %6.1f %6.1f %6.1f %6zu %8.1f %8.1f", quantile(now, 2), quantile(older, 2), quantile(none, 2),
                quantile(mask_none, 2), static_cast<size_t>(oldest), quantile(gaps_ms, 2), quantile(gaps_ms, 4));
  }
};

// Draws the frames and prints their times; the service's times are those of its newest finished frame.
void print_times(Engine& engine, sideray_osg::SceneAdapter* adapter, const Retrofit* retrofit, const Options& o,
                 const char* what, int budget_ms = 0) {
  std::vector<double> all, follow;
  Answers answers;
  double since_answer_ms = 0;
  sideray_ticket newest = retrofit ? retrofit->newest() : 0;
  // Within a budget answers arrive over several frames, so more frames precede the measurement.
  for (int i = budget_ms > 0 ? -o.frames : -2; i < o.frames; ++i) {
    const FrameTime t = draw_frame(engine, adapter, o.time_s + frame_s * std::max(i, 0));
    if (i < 0) continue;
    all.push_back(t.all_ms);
    follow.push_back(t.follow_ms);
    since_answer_ms += i == 0 ? 0 : t.all_ms;
    if (!retrofit || retrofit->newest() == newest) continue;
    newest = retrofit->newest();
    answers.gaps_ms.push_back(std::exchange(since_answer_ms, 0.0));
    answers.add(retrofit->stats());
  }
  std::printf("%-28s %8.1f %8.1f %8.1f %8.1f", what, quantile(all, 1), quantile(all, 2), quantile(all, 3), quantile(all, 4));
  if (retrofit) {
    const sideray_frame_stats s = retrofit->stats();
    std::printf("   %7.1f %7.1f %7.1f %7.1f %7.1f %8zu %8zu", quantile(follow, 2), s.readback_ms, s.trace_ms,
                s.trace_shadow_ms, s.upload_ms, static_cast<size_t>(s.rays_primary + s.rays_reflection),
                static_cast<size_t>(s.rays_shadow));
    answers.print();
  }
  std::printf("\n");
}

void print_stats(Engine& engine, const Options& o) {
  draw_frame(engine, nullptr, o.time_s);
  std::printf("%s, %dx%d, %d frames each; ms: quartiles of the engine's frame, and the longest; then of the last frame's "
              "service; then percent of the glass's pixels with an answer of this frame, an older one and none, of all pixels "
              "without a mask, medians; the oldest answer, frames; ms from one new answer to the next, median and most\n",
              engine.renderer().c_str(), o.engine.width, o.engine.height, o.frames);
  std::printf("%-28s %8s %8s %8s %8s   %7s %7s %7s %7s %7s %8s %8s %6s %6s %6s %6s %6s %8s %8s\n", "", "25 %", "median",
              "75 %", "most", "follow", "read", "trace", "shadows", "upload", "rays", "shadow", "now", "older", "none", "lit",
              "age", "answer", "most");
  print_times(engine, nullptr, nullptr, o, "service off");
  sideray_osg::SceneAdapter adapter(engine.scene(), terrace_rules());
  Retrofit retrofit(engine.viewer(), engine.scene(), adapter, o.retrofit);
  for (const bool wait : {true, false}) {
    retrofit.set_wait(wait);
    print_times(engine, &adapter, &retrofit, o, wait ? "synchronous" : "late");
  }
  for (const int budget_ms : {5, 10})
    for (const bool wait : {true, false}) {
      retrofit.set_wait(wait);
      retrofit.set_budget(static_cast<float>(budget_ms));
      print_times(
          engine, &adapter, &retrofit, o,
          ((wait ? "synchronous, budget " : "late, budget ") + std::to_string(budget_ms) + " ms").c_str(),
          budget_ms);
    }
}

// Continues without the retrofit if it failed.
void check(std::optional<Retrofit>& retrofit) {
  if (!retrofit || retrofit->error().empty()) return;
  std::fprintf(stderr, "osg_retrofit: %s; the engine goes on without\n", retrofit->error().c_str());
  retrofit.reset();
}

void run(Engine& engine, const Options& o) {
  std::optional<sideray_osg::SceneAdapter> adapter;
  std::optional<Retrofit> retrofit;
  if (o.sideray) {
    adapter.emplace(engine.scene(), terrace_rules());
    retrofit.emplace(engine.viewer(), engine.scene(), *adapter, o.retrofit);
  }
  sideray_osg::SceneAdapter* const follows = adapter ? &*adapter : nullptr;
  if (o.frames == 0) {
    const osg::ref_ptr<osgGA::TrackballManipulator> mouse = new osgGA::TrackballManipulator;
    mouse->setHomePosition(view_named(o.view).eye, view_named(o.view).target, {0, 1, 0});
    engine.viewer().setCameraManipulator(mouse);
    while (!engine.viewer().done()) {
      draw_frame(engine, follows, engine.viewer().elapsedTime());
      check(retrofit);
    }
    return;
  }
  for (int i = 0; i < o.frames; ++i) {
    engine.keep_picture(i + 1 == o.frames);
    draw_frame(engine, follows, o.time_s + frame_s * i);
    check(retrofit);
  }
  if (!o.output.empty() && !osgDB::writeImageFile(engine.picture(), o.output))
    throw std::runtime_error(o.output + ": cannot be written; does the folder exist?");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A legacy OpenGL engine, before and after its retrofit with ray-traced glass and shadows"};
  try {
    const Options o = parse(app, argc, argv);
    Engine engine(o.engine);
    const View& view = view_named(o.view);
    engine.look(view.eye, view.target, view.fov_deg);
    o.stats ? print_stats(engine, o) : run(engine, o);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "osg_retrofit: %s\n", error.what());
    return 1;
  }
}
