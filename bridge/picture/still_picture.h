// Adds up the pictures of a view that stands still, each drawn from another place in the pixel, until they are the picture of
// many camera positions: then nothing has to be drawn. Tiles that see something move begin anew, each by itself: the positions
// come again and again in one order, and each tile takes them from where it begins. One thread calls it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::bridge {

class StillPicture {
 public:
  // A still view adds up this many positions, and is then the picture of as many `samples`.
  static constexpr uint32_t positions = 64;

  // A picture of this size is drawn that is not the last one.
  void restart(uint32_t seed, uint32_t width, uint32_t height);
  // The last picture is drawn once more.
  void repeat();
  // Except in tiles that have changed (TileChange, of rt::frame_tile_size), which begin anew. Tiles that change again
  // and again are lit anew in a few of these pictures only.
  void repeat_without(const std::vector<uint8_t>& changes);

  // Whether the picture is drawn from position() and added to those before; otherwise it is drawn as any other is.
  bool adds() const { return pictures_ > 0 && !is_done_; }
  // Whether all tiles have added up all positions: the picture is the last one.
  bool is_done() const { return is_done_; }
  uint32_t position() const { return static_cast<uint32_t>((pictures_ - 1) % positions); }
  // Whether the last picture was drawn from position() already and lacked answers.
  bool waits() const { return waits_; }
  // How many frames it is drawn in, this one included.
  uint32_t position_frames() const { return position_frames_; }
  // The random numbers that position 0 is drawn with, as sideray_render_options::seed.
  uint32_t seed() const { return seed_; }
  // Whether the last picture was accumulated.
  bool has_added() const { return pictures_ > 0; }
  // Of how many positions every tile is the mean at least; 0 where one is that of none.
  uint32_t added() const;
  // The tiles that take the picture which is drawn, and those of them in which surfaces are lit anew; empty: all.
  std::vector<uint8_t> wanted() const;
  std::vector<uint8_t> wanted_light() const;
  // Whether some tile restarts with the picture that is being drawn.
  bool begins_tiles() const { return begins_tiles_; }

  // Takes a picture that was not added. `averaged`: of how many pictures it is an average over time, at least 1.
  void begin_with(const std::vector<glm::vec4>& picture, uint32_t averaged);
  // Takes what was drawn from position() and returns what is shown. `average`: with tiles that begin anew, the average over time
  // that these show.
  const std::vector<glm::vec4>& add(const std::vector<glm::vec4>& drawn, const std::vector<glm::vec4>& average);
  // Call if the picture from position() lacks answers because of the budget: it is drawn once more. Returns what is
  // shown.
  const std::vector<glm::vec4>& wait() {
    waits_ = true;
    return shown_;
  }
  // Returns what was shown last; with adds() or is_done().
  const std::vector<glm::vec4>& shown() const { return shown_; }

 private:
  struct Tile {
    uint32_t added = 0;
    bool begins = false, rests = false;  // of the picture that is drawn, it shows the average; and adds nothing
    float averaged = 0.0f;          // for how many positions the picture from before counts
    std::vector<glm::vec4> before;  // empty where it no longer does
    std::vector<glm::dvec4> sum;    // empty where it is whole
  };

  uint32_t columns() const;
  template <typename Wants>
  std::vector<uint8_t> tiles_where(const Wants& wants) const;
  template <typename Work>
  void for_texels(size_t tile, const Work& work) const;

  uint64_t pictures_ = 0;  // that were added, and the one that is drawn
  uint32_t seed_ = 0, width_ = 0, height_ = 0, position_frames_ = 0;
  bool is_done_ = false, begins_tiles_ = false, waits_ = false;
  std::vector<Tile> tiles_;
  std::vector<glm::vec4> shown_;
};

}  // namespace sideray::bridge
