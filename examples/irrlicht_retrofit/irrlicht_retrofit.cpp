// Runs an engine on Irrlicht, with ray-traced glass or in its original state: docs/fixed-function.md.
//
//   irrlicht_retrofit [--sideray] [--late] [--budget MS] [--frames N] [--size WIDTHxHEIGHT] [--save FILE.png]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "room.h"
#include "sideray_irrlicht.h"

namespace {

struct Arguments {
  bool sideray = false;
  sideray_irrlicht::Settings settings;
  unsigned width = 640, height = 360, frames = 0;
  std::string file;
};

Arguments parse(int count, char** words) {
  Arguments a;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const char* value = i + 1 < count ? words[i + 1] : "";
    if (word == "--sideray") a.sideray = true;
    else if (word == "--late") a.settings.wait = false;
    else if (word == "--no-shadows") a.settings.shadows = false;
    else if (word == "--budget") a.settings.budget_ms = std::strtof(value, nullptr), ++i;
    else if (word == "--frames") a.frames = static_cast<unsigned>(std::atoi(value)), ++i;
    else if (word == "--size") std::sscanf(value, "%ux%u", &a.width, &a.height), ++i;
    else if (word == "--save") a.file = value, ++i;
    else throw std::runtime_error(word + ": not an option");
  }
  return a;
}

void run(const Arguments& a) {
  Room room(a.width, a.height);
  std::unique_ptr<sideray_irrlicht::Retrofit> retrofit;
  if (a.sideray) retrofit = std::make_unique<sideray_irrlicht::Retrofit>(room.device(), a.settings);
  const auto start = std::chrono::steady_clock::now();
  unsigned frames = 0;
  Picture picture;
  for (; a.frames == 0 || frames < a.frames; ++frames) {
    room.set_time(frames * 33);
    if (retrofit) retrofit->update();
    if (!room.draw(a.file.empty() ? nullptr : &picture)) break;
    if (retrofit && !retrofit->error().empty()) {
      std::fprintf(stderr, "%s\n", retrofit->error().c_str());
      retrofit.reset();
    }
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  std::printf("%u frames, %.1f ms each\n", frames, took.count() / frames);
  if (retrofit && retrofit->stats().pixels_masked > 0) {
    const sideray_frame_stats& last = retrofit->stats();
    std::printf("%.1f %% of the last frame's glass has a ray-traced answer\n",
                100.0 * static_cast<double>(last.pixels_masked - last.pixels_late) / static_cast<double>(last.pixels_masked));
  }
  if (!a.file.empty()) room.save(picture, a.file);
}

}  // namespace

int main(int count, char** words) {
  try {
    run(parse(count, words));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
