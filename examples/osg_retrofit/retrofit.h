// Requests a frame of Sideray between the engine's opaque and blended draws, and shows its answers. Call it on the
// drawing thread with the engine's context current; only the constructor touches adapter and graph.
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
  bool wait = true;  // for this frame's rays; else the newest answers are shown, mostly one frame old
  uint32_t layers = 4;
  bool shadows = true;
  float deadline_ms = 0;  // rays not begun by then are skipped, and older answers shown; 0 = none
  uint32_t threads = 0;   // 0 = all
};

class Retrofit {
 public:
  Retrofit(osgViewer::Viewer& viewer, osg::Group& root, const sideray_osg::SceneAdapter& adapter,
           const RetrofitSettings& settings);
  // Removes everything from the graph: the engine draws as before. Call it on the drawing thread.
  ~Retrofit();
  Retrofit(const Retrofit&) = delete;
  Retrofit& operator=(const Retrofit&) = delete;

  void set_wait(bool wait);
  void set_deadline(float milliseconds);
  // Returns why the retrofit has stopped, empty if it has not. Then destroy it: glass without answers is drawn wrongly.
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
