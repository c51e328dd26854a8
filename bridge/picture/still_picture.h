// Adds up the pictures of a view that stands still, each drawn from another place in the pixel, until they are the picture of
// many camera positions: then nothing has to be drawn. One thread calls it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace sideray::bridge {

class StillPicture {
 public:
  // A still view adds up this many positions, and is then the picture of as many `samples`.
  static constexpr uint32_t positions = 64;

  // A picture is drawn that is not the last one.
  void restart(uint32_t seed);
  // The last picture is drawn once more.
  void repeat() { pictures_ = is_done() || waits_ ? pictures_ : pictures_ + 1; }

  // Whether the picture is drawn from position() and added to those before; otherwise it is drawn as any other is.
  bool adds() const { return pictures_ > 0 && !is_done(); }
  // Whether all positions have been added up: the picture is the last one.
  bool is_done() const { return pictures_ > positions; }
  uint32_t position() const { return pictures_ - 1; }
  // Whether the last picture was drawn from position() already and lacked answers.
  bool waits() const { return waits_; }
  // The random numbers that position 0 is drawn with, as sideray_render_options::seed.
  uint32_t seed() const { return seed_; }
  // How many positions the picture is the mean of; 0 where it is none.
  uint32_t added() const { return is_done() ? positions : pictures_ - waits_; }

  // Takes a picture that was not added. `averaged`: of how many pictures it is an average over time, at least 1.
  void begin_with(const std::vector<glm::vec4>& picture, uint32_t averaged);
  // Takes what was drawn from position() and returns what is shown.
  std::vector<glm::vec4> add(const std::vector<glm::vec4>& drawn);
  // What was drawn from position() lacks answers for want of time: it is drawn once more. Returns what is shown.
  std::vector<glm::vec4> wait();
  // Returns what was shown last; with adds() or is_done().
  std::vector<glm::vec4> shown() const;

 private:
  uint32_t pictures_ = 0;  // in a row before this one that were the same, at most positions + 1
  bool waits_ = false;
  uint32_t seed_ = 0;
  float averaged_ = 0.0f;
  std::vector<glm::vec4> first_, sum_;
  uint32_t summed_ = 0;
};

}  // namespace sideray::bridge
