// Holds the engine's own code: a room in Irrlicht as it was programmed in 2010, left-handed, with the fixed function's
// lights and materials. It knows nothing of rays.
#pragma once

#include <irrlicht/irrlicht.h>

#include <string>
#include <vector>

// Bytes in the order blue, green, red, alpha; top row first.
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
  // Sets the scene's time, so that pictures do not depend on the frame rate.
  void set_time(irr::u32 ms);
  // Edit the level: add or remove a crate.
  void add_crate();
  void remove_crate();
  void show_smoke(bool shown) { smoke_->setVisible(shown); }
  void turn_camera(float degrees);

  // Draws a frame, and copies it to `picture` if that is not null. Returns false when the window is closed.
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
