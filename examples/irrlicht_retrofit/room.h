// The engine's own program: a room in Irrlicht in the style of 2010, left-handed, with the fixed function's lights and
// materials. It does not know Sideray.
#pragma once

#include <irrlicht/irrlicht.h>

#include <string>
#include <vector>

// Holds bytes of blue, green, red and alpha, top row first.
struct Picture {
  unsigned width = 0, height = 0;
  std::vector<unsigned char> bgra;
};

class Room {
 public:
  Room(unsigned width, unsigned height);
  ~Room();
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;

  irr::IrrlichtDevice& device() const { return *device_; }
  irr::scene::ISceneManager& scene() const { return *device_->getSceneManager(); }
  // Sets the time of the animation, so that pictures do not depend on the speed of drawing.
  void set_time(irr::u32 ms);
  // Both edit the level.
  void add_crate();
  void remove_crate();
  void show_smoke(bool shown) { smoke_->setVisible(shown); }
  void turn_camera(float degrees);

  // Draws a frame, and copies it to `picture` if it is not null. Returns false once the window is closed.
  bool draw(Picture* picture = nullptr);
  void save(const Picture& picture, const std::string& file) const;

 private:
  irr::video::ITexture* checks(const char* name, irr::video::SColor a, irr::video::SColor b) const;
  irr::scene::ISceneNode* add_box(irr::core::vector3df size, irr::core::vector3df place, irr::video::ITexture* texture) const;
  void add_walls() const;
  void add_glass() const;
  void add_banner();
  void add_lights() const;

  irr::IrrlichtDevice* device_;
  irr::scene::ISceneNode* crate_ = nullptr;
  irr::scene::ISceneNode* smoke_ = nullptr;
  irr::scene::IAnimatedMeshSceneNode* banner_ = nullptr;
};
