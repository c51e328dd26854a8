// The hook: what asks Sideray for a frame between the engine's opaque and blended draws, and what reads the answers.
// The thread that draws, with the engine's context current; adapter and graph are only touched in the constructor.
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
  bool wait = true;  // for this frame's rays; else the frame shows the newest answers there are, mostly one frame old
  uint32_t layers = 4;
  bool shadows = true;
  float deadline_ms = 0;  // rays that have not begun by then are given up, and older answers shown; 0 = none
  uint32_t threads = 0;   // 0 = all
};

class Retrofit {
 public:
  Retrofit(osgViewer::Viewer& viewer, osg::Group& root, const sideray_osg::SceneAdapter& adapter,
           const RetrofitSettings& settings);
  // Takes everything off the graph again; the engine draws as before. On the thread that draws.
  ~Retrofit();
  Retrofit(const Retrofit&) = delete;
  Retrofit& operator=(const Retrofit&) = delete;

  void set_wait(bool wait);
  void set_deadline(float milliseconds);
  // Why it gave up, empty while all is well. Then destroy it: glass without answers is not drawn right.
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
