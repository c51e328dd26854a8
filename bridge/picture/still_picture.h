// Accumulates the pictures of a view at rest, each from another position in the pixel, until they equal a picture of
// many samples: then nothing is drawn any more. A tile that sees something move restarts alone: the positions repeat in
// one order, and each tile starts with the current one.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::bridge {

class StillPicture {
 public:
  // A still view adds this many positions, and then equals a picture of as many `samples`.
  static constexpr uint32_t positions = 64;

  // Starts over, for a picture of this size that differs from the last one.
  void restart(uint32_t seed, uint32_t width, uint32_t height);
  // Call it where the last picture is drawn again.
  void repeat();
  // Does the same, but restarts the tiles that have changed (TileChange, of rt::frame_tile_size). Tiles that keep
  // changing are relit in only a few pictures.
  void repeat_without(const std::vector<uint8_t>& changes);

  // Returns whether the picture is drawn from position() and added to those before; otherwise it is drawn normally.
  bool adds() const { return pictures_ > 0 && !is_done_; }
  // Returns whether all tiles have all positions: nothing is left to draw.
  bool is_done() const { return is_done_; }
  uint32_t position() const { return static_cast<uint32_t>((pictures_ - 1) % positions); }
  // Returns whether the last picture was drawn from position() already and lacked answers.
  bool waits() const { return waits_; }
  // Returns how many frames the position has taken, this one included.
  uint32_t position_frames() const { return position_frames_; }
  // Returns the random seed of position 0, as sideray_render_options::seed.
  uint32_t seed() const { return seed_; }
  // Returns whether the last picture was accumulated.
  bool has_added() const { return pictures_ > 0; }
  // Returns the smallest number of positions that a tile has added.
  uint32_t added() const;
  // Return the tiles that the picture is drawn for, and those among them that are relit; empty: all.
  std::vector<uint8_t> wanted() const;
  std::vector<uint8_t> wanted_light() const;
  // Returns whether some tile restarts with the current picture.
  bool begins_tiles() const { return begins_tiles_; }

  // Starts from a picture that was not accumulated. `averaged`: how many pictures it averages over time, at least 1.
  void begin_with(const std::vector<glm::vec4>& picture, uint32_t averaged);
  // Adds the picture drawn from position() and returns what to show. `average`: the temporal average, which restarting
  // tiles show.
  const std::vector<glm::vec4>& add(const std::vector<glm::vec4>& drawn, const std::vector<glm::vec4>& average);
  // Call it if the picture from position() lacks answers because of the budget: the position is drawn again. Returns
  // what to show.
  const std::vector<glm::vec4>& wait() {
    waits_ = true;
    return shown_;
  }
  // Returns what was shown last; only with adds() or is_done().
  const std::vector<glm::vec4>& shown() const { return shown_; }

 private:
  struct Tile {
    uint32_t added = 0;
    bool begins = false, rests = false;  // with this picture: starts again, or adds nothing; both show the average
    float averaged = 0.0f;          // weight of the picture from before, in positions
    std::vector<glm::vec4> before;  // empty once it has no weight
    std::vector<glm::dvec4> sum;    // empty once it is complete
  };

  uint32_t columns() const;
  template <typename Wants>
  std::vector<uint8_t> tiles_where(const Wants& wants) const;
  template <typename Work>
  void for_texels(size_t tile, const Work& work) const;

  uint64_t pictures_ = 0;  // number of pictures added, the current one included
  uint32_t seed_ = 0, width_ = 0, height_ = 0, position_frames_ = 0;
  bool is_done_ = false, begins_tiles_ = false, waits_ = false;
  std::vector<Tile> tiles_;
  std::vector<glm::vec4> shown_;
};

}  // namespace sideray::bridge
