// Connects Sideray to the engine: requests a frame between the engine's opaque and blended draws, and reads the
// answers. On the thread that draws, with the engine's context current; adapter and graph are used in the constructor
// only.
#pragma once

#include <osg/Group>
#include <osg/Program>
#include <osgViewer/Viewer>

#include <memory>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "sideray_osg.h"

struct RetrofitSettings {
  bool wait = true;  // for this frame's rays; otherwise the frame shows the newest answers, mostly one frame old
  uint32_t layers = 4;
  bool shadows = true;
  float budget_ms = 0;    // that rays may add to a frame, which shows older answers elsewhere; 0: no limit
  uint32_t threads = 0;   // 0: all
};

class Retrofit {
 public:
  Retrofit(osgViewer::Viewer& viewer, osg::Group& root, const sideray_osg::SceneAdapter& adapter,
           const RetrofitSettings& settings);
  // Removes everything from the graph, so that the engine draws as before. On the thread that draws.
  ~Retrofit();
  Retrofit(const Retrofit&) = delete;
  Retrofit& operator=(const Retrofit&) = delete;

  void set_wait(bool wait);
  void set_budget(float milliseconds);
  // Returns the reason why the retrofit stopped, empty if it runs. Destroy it then: glass without answers is drawn
  // wrong.
  const std::string& error() const;
  // Return the statistics of the newest finished frame, and its ticket; 0 before the first.
  sideray_frame_stats stats() const;
  sideray_ticket newest() const;

 private:
  class Hook;
  osgViewer::Viewer& viewer_;
  osg::Group& root_;
  osg::ref_ptr<Hook> hook_;
  osg::ref_ptr<osg::Group> passes_;
  std::vector<sideray_osg::Glass> glass_;
  osg::ref_ptr<osg::Program> glass_program_, shadow_program_;
};
