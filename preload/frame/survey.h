// Counts the textures and meshes that the program drew, and what they were taken for. Writes the page of --report.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "preload/base/rules.h"
#include "preload/capture/draw_state.h"
#include "preload/capture/textures.h"

namespace sideray::run {

// Says what becomes of a draw.
enum class Taking { left, opaque, sky, reflects, held };

class Survey {
 public:
  struct Entry {
    uint64_t draws = 0, frames = 0, last_frame = 0, blended = 0, lit = 0;
    std::set<std::string> taken;
  };
  struct Frame {
    uint64_t pixels = 0, reflecting = 0;             // of the view; fragments that show ray-traced radiance
    uint64_t in_shadow = 0, held_in_shadow = 0;      // pixels that shadows darken: of opaque draws, of held draws
    double trace_ms = 0, frame_ms = 0;  // 0 = not known
    size_t instances = 0, meshes = 0, held = 0, batches = 0;
    uint64_t rays = 0, shadow_rays = 0, layers = 0;
  };

  void note(const Texture& texture, uint64_t mesh, const DrawState& state, Taking taking, const Rule& rule);
  void miss(const std::string& what) { ++missed_[what]; }
  void end_frame(const Frame& frame);
  // Writes the page. Returns false if the file cannot be written.
  bool write(const std::string& path, const std::string& renderer, const std::string& ended) const;

 private:
  struct Thumbnail {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;
  };
  static void count(Entry& entry, uint64_t frame, const DrawState& state, const std::string& taken);
  static Thumbnail thumbnail(const Texture& texture);
  std::string figures() const;
  std::string table(const std::map<uint64_t, Entry>& entries, bool with_pictures) const;

  uint64_t frame_ = 1, frames_with_rays_ = 0, frames_with_shadows_ = 0, frames_traced_ = 0;
  double share_ = 0, most_share_ = 0, shadow_share_ = 0, held_shadow_share_ = 0, trace_ms_ = 0;
  std::vector<float> frame_ms_;
  double memory_mb_[2] = {};  // at frames 100 and 1000
  Frame last_, total_;
  std::map<uint64_t, Entry> textures_, meshes_;
  std::map<uint64_t, Thumbnail> pictures_;
  std::map<std::string, uint64_t> missed_;
};

}  // namespace sideray::run
